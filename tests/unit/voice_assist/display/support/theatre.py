# SPDX-License-Identifier: BSD-3-Clause
"""A theatre as it may be, and a page of it that acts on nothing."""

import time
from dataclasses import replace

from typed_config import load_file
from voice_assist.config.display import FILE, DisplayConfig
from voice_assist.display.access_token import AccessToken
from voice_assist.display.acts import Outcome
from voice_assist.display.server import DisplayServer
from voice_assist.display.snapshot import AlarmPart, RobotPart, TissuePart, UtterancePart
from voice_assist.display.theatre import Limits, Theatre
from voice_assist.display.words import WordRule

TOKEN = "ABCDEFGH"
ANY = frozenset({"standby", "active", "moving", "stopping", "halted", "faulted"})
BOTH = frozenset({"standby", "active"})
RULES = (
    WordRule("hey robot", BOTH, ANY, None),
    WordRule("tense", frozenset({"active"}), frozenset({"active"}), False),
    WordRule("release", frozenset({"active"}), frozenset({"active"}), True),
    WordRule("pull more", frozenset({"active"}), frozenset({"active", "moving"}), True),
    WordRule("pull less", frozenset({"active"}), frozenset({"active", "moving"}), True),
    WordRule("stop", BOTH, ANY, None),
)
PULLING = RobotPart("moving", "pull", "tense", 0.4, True, "")
HALTED = RobotPart("halted", "hold", "tense", 1.0, True, "stopped by /display")
TISSUE = TissuePart(0.62, 1.0, 2.3e-5, 0.121)
STOPPED = AlarmPart("stop", 2, "stopped by /display", 'say "hey robot" to go on')


class Clock:
    """A steady clock that a test sets [s]."""

    def __init__(self):
        self.now = 100.0

    def __call__(self):
        return self.now


def make_theatre(clock=time.monotonic):
    """A theatre of which everything is known, in the middle of a pull."""
    theatre = Theatre(0.5, clock, lambda: 1.8e9)
    theatre.rules, theatre.limits = RULES, Limits(2.4, 1e-3)
    theatre.see_robot(PULLING, TISSUE)
    theatre.see_sound(-31.0)
    theatre.see_mode("active")
    theatre.see_voice_health("USB condenser microphone", "")
    theatre.see_utterance(UtterancePart(" Tense.", "tense", "", "recognizer"))
    theatre.see_alarm(AlarmPart())
    theatre.see_recording("")
    theatre.see_file("/sessions/2026-11-25T10-00-00/session.mcap")
    theatre.see_free_space(120_000_000_000)
    return theatre


class RecordedActs:
    """Keeps what is asked for."""

    def __init__(self):
        self.asked = []

    def send_stop(self):
        self.asked.append("sent stop")

    def stop(self):
        return self._take("stop")

    def choose_microphone(self, name):
        return self._take(("microphone", name))

    def answer(self, command, is_yes):
        return self._take(("answer", command, is_yes))

    def set_grasp_point(self, x, y, stamp):
        return self._take(("grasp", x, y, stamp))

    def _take(self, what):
        self.asked.append(what)
        return Outcome(True, "done")


def make_server(theatre=None, acts=None, clock=time.monotonic, errors=None, **settings):
    """A page at any free port; its token is TOKEN."""
    config = replace(load_file(DisplayConfig, FILE), **{"port": 0, **settings})
    return DisplayServer(
        config,
        theatre or make_theatre(),
        acts or RecordedActs(),
        AccessToken(clock, TOKEN),
        (errors if errors is not None else []).append,
    )

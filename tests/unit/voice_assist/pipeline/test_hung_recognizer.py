# SPDX-License-Identifier: BSD-3-Clause
"""Recognition that hangs or crashes: the robot is stopped, the spotter goes on, nothing is hidden.

The threads of the node are the real ones; ROS, the networks and the clock are made up.
"""

import threading
from collections import deque
from contextlib import suppress
from dataclasses import replace
from importlib import import_module
from pkgutil import extend_path
from queue import Queue
from types import SimpleNamespace

import pytest
from diagnostic_msgs.msg import DiagnosticStatus

import rst_control
import voice_assist
from support.waiting import PATIENCE, wait_until
from tests.unit.voice_assist.support.fake_speech import FakeRecognizer, frames, make_detector, say
from voice_assist.config import load_voice_config
from voice_assist.pipeline.hang_detection import HangWatch
from voice_assist.pipeline.pipeline import Pipeline
from voice_assist.spotter.fusion import StopFusion
from voice_assist.spotter.spotter import Spotted
from voice_assist.types import (
    Ask,
    Call,
    HearingFault,
    Hypothesis,
    Mode,
    NoMatch,
    Rejection,
    RejectionReason,
    UtteranceDecision,
)

for package in (rst_control, voice_assist):  # pytest's paths hide the generated messages
    package.__path__ = extend_path(package.__path__, package.__name__)
node = import_module("voice_assist.ros.voice_node")
robot_acts = import_module("voice_assist.ros.robot.robot_acts")
diagnostics = import_module("voice_assist.ros.diagnostics")

BEATS = 5  # heartbeats that show that they go on
CONFIG = load_voice_config()
LIMIT, MIDDLE = CONFIG.recognizer.hung_after, CONFIG.spotter.middle


class Moody(FakeRecognizer):
    """Hears, but for a time hangs for ever, or crashes, or takes time."""

    def __init__(self, clock):
        super().__init__()
        self.clock, self.passes = clock, 0
        self.takes, self.error, self.is_hanging = 0.0, None, False
        self.hangs, self.go = threading.Event(), threading.Event()

    def transcribe(self, samples, *more):
        self.passes += 1
        self.clock.now += self.takes
        if self.error is not None:
            raise self.error
        if self.is_hanging:
            self.hangs.set()
            assert self.go.wait(PATIENCE)
        return super().transcribe(samples, *more)


class Spotter:
    """Spots once, after a test has set `is_said`; raises `error`, which ends its thread."""

    def __init__(self):
        self.heard, self.is_said = [], False
        self.score = self.error = None

    def __call__(self, frame):
        if self.error is not None:
            raise self.error
        self.heard.append(frame.first_sample)
        is_said, self.is_said = self.is_said, False
        return Spotted(frame.stamp, 9.0) if is_said else None

    def best(self, since, until=0):
        return self.score

    def reset(self):
        raise AssertionError("the stream of a thread is its own")


class Room:
    """What the node hears, and all that it does."""

    remark = ""

    def __init__(self, monkeypatch, clock):
        self.sound, self.done = Queue(), threading.Event()
        self.seen = deque()
        self.recognizer, self.spotter = Moody(clock), Spotter()
        self.calls_dropped, self.ended = 0, []
        self._next = 0
        quiet = lambda *_, **__: None  # noqa: E731
        fake_rospy = SimpleNamespace(
            set_param=quiet,
            loginfo=quiet,
            logwarn=quiet,
            logerr=quiet,
            logfatal=quiet,
            on_shutdown=quiet,
            is_shutdown=self.done.is_set,
            signal_shutdown=self.ended.append,
            spin=self.done.wait,
        )
        caller = SimpleNamespace(call=quiet, forget=self.forget, trouble="")
        replaced = {
            "rospy": fake_rospy,
            "WATCH_PERIOD": 0.002,
            "_HEARTBEAT_EVERY": 1,
            "_now": lambda: clock.now,
            "_steady": lambda: clock.now,
            "HangWatch": lambda allowed: HangWatch(allowed, dict, dict),  # nobody lacks a processor
            "Publishers": lambda: self,
            "CommandClient": lambda *_: caller,
            "Believed": lambda: SimpleNamespace(hear=quiet, publish_status=quiet),
            "RobotSpeechTopic": lambda *_: SimpleNamespace(take=list),
            "TalkTopic": lambda *_: SimpleNamespace(take=list),
            "QuestionService": lambda: SimpleNamespace(start=quiet, take=list),
            "VoiceDiagnostics": self.diagnostics,
            "make_recognizer": lambda _: self.recognizer,
            "make_spotters": lambda _: (self.spotter, "0"),
            "make_source": lambda *_: self,
            "make_pipeline": self.pipeline,
        }
        for name, value in replaced.items():
            modules = [module for module in (node, robot_acts) if hasattr(module, name)]
            assert modules, name
            for module in modules:
                monkeypatch.setattr(module, name, value)
        self.node = node.VoiceNode(load_voice_config())
        self._before = set(threading.enumerate())
        threading.Thread(target=self._run).start()

    def _run(self):
        with suppress(SystemExit):  # after a crash
            self.node.run()

    # --- in place of parts of the node

    @staticmethod
    def pipeline(config, clock, recognizer, spotting, observer):
        second = StopFusion(config.spotter, spotting)
        return Pipeline(config, recognizer, make_detector(), clock, second, observer)

    def diagnostics(self, health, clock, deaf_after):
        def publish():
            summary = diagnostics._summary(health, clock(), deaf_after)
            self.seen.append(("diagnostics", *summary))

        return SimpleNamespace(publish=publish)

    def forget(self):
        self.calls_dropped += 1

    def __enter__(self):
        return self

    def __iter__(self):
        return iter(self.sound.get, None)

    def __exit__(self, *_):
        pass

    def __getattr__(self, name):
        """A publisher."""
        if name not in ("audio", "side_input", "partial", "utterance", "mode", "stop", "heartbeat"):
            raise AttributeError(name)
        return lambda *_: self.seen.append((name,))

    # --- what a test does

    def hear(self, words):
        """Let words come in, in no time; gives the samples that came since the beginning."""
        for frame in frames(say(words), self._next, 0.0):
            self._next = frame.next_sample
            self.sound.put(replace(frame, stamp=self.recognizer.clock.now - frame.duration))
        return self._next

    def skip(self, samples):
        """Lose samples of the sound that comes."""
        self._next += samples

    def count(self, kind):
        return sum(entry[0] == kind for entry in list(self.seen))

    def more(self, kind, number):
        """Wait until that much more of a kind was published."""
        enough = self.count(kind) + number
        wait_until(lambda: self.count(kind) >= enough, f"{number} more {kind}")

    def reach(self, kind, number):
        """Wait until so much of a kind was published in all."""
        wait_until(lambda: self.count(kind) >= number, f"{number} {kind} in all")

    def state(self):
        """Level and words of the newest diagnostics."""
        return [entry[1:] for entry in list(self.seen) if entry[0] == "diagnostics"][-1]

    def hang(self):
        """Hang while a word is heard."""
        self.recognizer.is_hanging = True
        self.hear("tense")
        assert self.recognizer.hangs.wait(PATIENCE)
        self.more("heartbeat", 2)  # the watch has seen when it began

    def go_on(self):
        """End the hang."""
        self.recognizer.is_hanging = False
        self.recognizer.go.set()

    def hang_too_long(self, times=1.05):
        """Hang, until the robot is stopped for it."""
        self.hang()
        self.recognizer.clock.now += times * LIMIT
        self.reach("stop", 1)

    def is_without_heartbeat(self):
        """Whether none comes while diagnostics do."""
        self.more("diagnostics", 2)
        beats = self.count("heartbeat")
        self.more("diagnostics", 2)
        return self.count("heartbeat") == beats

    def close(self):
        self.go_on()
        self.sound.put(None)
        self.done.set()
        for thread in set(threading.enumerate()) - self._before:  # before rospy is the true one
            if thread.name != "spotter":  # which waits for sound for ever
                thread.join(PATIENCE)


@pytest.fixture
def clock():
    return SimpleNamespace(now=0.0)


@pytest.fixture
def room(monkeypatch, clock):
    room = Room(monkeypatch, clock)
    room.hear("")  # a quiet room
    room.more("heartbeat", 1)
    yield room
    room.close()


def test_a_pass_that_takes_as_long_as_it_may_is_no_hang(room, clock):
    room.hang()
    clock.now += 0.95 * LIMIT
    room.more("heartbeat", BEATS)
    assert room.count("stop") == 0


def test_a_hang_stops_the_robot_once_and_ends_the_heartbeat(room):
    room.hang_too_long()
    assert room.calls_dropped == 1  # what was to be called goes with it
    assert room.is_without_heartbeat()
    assert room.count("stop") == 1


def test_diagnostics_name_the_hang_and_what_is_allowed(room):
    room.hang_too_long(10.0)
    room.more("diagnostics", 1)
    level, words, fault = room.state()
    assert level == DiagnosticStatus.ERROR and fault is HearingFault.HANGS
    assert words == f"recognition hangs: {10 * LIMIT:.2f} s on one frame, allowed {LIMIT:g} s"


def test_a_hang_does_not_hide_a_stop_from_the_spotter(room):
    room.hang_too_long()
    room.spotter.is_said = True
    end = room.hear("stop")
    wait_until(lambda: room.spotter.heard[-1] >= end - 512, "the spotter hears on")
    assert room.count("stop") == 2  # although the first was but a moment ago
    assert room.count("utterance") == 0  # recognition itself hears nothing


def test_in_a_hang_the_spotter_stops_once_where_else_it_would_ask_the_recognizer(room, clock):
    room.hang()
    room.spotter.score = MIDDLE
    room.more("heartbeat", BEATS)
    assert room.count("stop") == 0
    clock.now += 1.05 * LIMIT
    room.reach("stop", 2)  # for the hang, and for the word
    room.more("diagnostics", 2)
    assert room.count("stop") == 2
    assert room.count("utterance") == 0


def test_the_spotter_stops_before_the_hang_is_noticed(room):
    room.hang()
    room.spotter.is_said = True
    end = room.hear("")
    wait_until(lambda: room.spotter.heard[-1] >= end - 512, "the spotter hears on")
    assert room.count("stop") >= 1


def test_after_a_hang_that_ends_the_heartbeat_comes_back_and_nothing_else(room):
    room.hang_too_long()
    room.go_on()
    room.more("heartbeat", BEATS)
    assert room.count("stop") == 1


def test_passes_that_are_slow_each_but_within_the_limit_never_add_up_to_a_hang(room):
    room.recognizer.takes = LIMIT / 4
    room.hear("hey robot 1 mumble mumble 1 the now")
    wait_until(lambda: room.recognizer.passes > 8, "many passes")
    room.recognizer.takes = 0.0
    room.more("diagnostics", 2)
    assert room.count("stop") == 0


def test_a_recognizer_that_crashes_stops_the_robot_at_once_and_is_named(room):
    room.recognizer.error = ArithmeticError("no such number")
    room.hear("tense")
    wait_until(lambda: "hear: no such number" in room.ended, "the node ends with the reason")
    assert room.count("stop") == 1
    assert room.is_without_heartbeat()
    level, *named = room.state()
    assert level == DiagnosticStatus.ERROR
    assert named == ["hear: no such number", HearingFault.THREAD_ENDED]


def test_a_spotter_that_crashes_is_named_and_the_recognizer_alone_hears_a_stop(room):
    room.spotter.error = ArithmeticError("no such number")
    room.hear("")
    wait_until(lambda: room.state()[2] is HearingFault.SPOTTER_FAILED, "the failure is named")
    named = "spotter: no such number; the recogniser alone hears a stop"
    assert room.state()[:2] == (DiagnosticStatus.ERROR, named)
    room.more("heartbeat", BEATS)
    assert room.count("stop") == 0 and not room.ended
    room.hear("stop")
    room.reach("stop", 1)
    assert room.state()[2] is HearingFault.SPOTTER_FAILED  # until the node is started again


def test_gaps_that_come_often_end_the_heartbeat_until_they_are_over(room, clock):
    for _ in range(3):
        room.skip(512)
        room.hear("")
    wait_until(lambda: "torn" in room.state()[1], "the gaps are named")
    assert room.is_without_heartbeat()
    assert room.state()[2] is HearingFault.TORN
    clock.now += 1.1 * CONFIG.audio.deaf_after
    room.hear("")
    room.more("heartbeat", BEATS)


def test_what_a_topic_says_of_the_clocks_ends_the_heartbeat(room):
    room.node._config = load_voice_config(audio__source="topic")
    room.node._source()._report_clocks("the clock of the sound's host is 1.30 s ahead")
    assert room.is_without_heartbeat()
    assert room.state()[2] is HearingFault.CLOCKS


@pytest.mark.parametrize(("action", "shown"), [(Ask("tense"), [7.0]), (Call("tense"), [])])
def test_the_time_of_a_question_begins_once_it_is_published(monkeypatch, action, shown):
    monkeypatch.setattr(node, "_now", lambda: 7.0)
    told = []
    bare = object.__new__(node.VoiceNode)
    bare._robot = SimpleNamespace(do=told.append)
    bare._publish = SimpleNamespace(utterance=lambda *_: told.append("published"))
    bare._pipeline = SimpleNamespace(question_shown=told.append)
    refused = NoMatch(Rejection(RejectionReason.NEARLY_SURE, "asked"), "tense")
    heard, times = Hypothesis("tense", -0.1, 0.0), (0.0, 1.0, 1.0)
    event = UtteranceDecision(heard, refused, 0.5, Mode.ACTIVE, *times, False, actions=(action,))
    bare._take(event)
    assert told == [action, "published", *shown]

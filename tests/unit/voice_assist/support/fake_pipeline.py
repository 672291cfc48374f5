# SPDX-License-Identifier: BSD-3-Clause
"""The pipeline without its networks, and what came of a sentence in the language of tones."""

from tests.unit.voice_assist.support.fake_speech import FakeRecognizer, frames, make_detector, say
from voice_assist.config import load_voice_config
from voice_assist.pipeline.pipeline import Pipeline
from voice_assist.side_inputs import ignore
from voice_assist.spotter.fusion import StopFusion
from voice_assist.spotter.spotter import Spotted
from voice_assist.types import Match, Mode, NoMatch, UtteranceDecision

COMMANDS = ("hey robot", "tense", "release", "pull more", "pull less", "stop", "terminate")


class StreamClock:
    """Shows the time at which the newest frame ended."""

    def __init__(self):
        self.now = 0.0

    def __call__(self):
        return self.now


class FakeSpotting:
    """A spotter with one score, whatever it hears; fires once, from a clock time on."""

    def __init__(self, score=None, at=None, is_sent=False):
        self.score, self.at, self.is_sent = score, at, is_sent

    def __call__(self, frame):
        if self.at is None or frame.stamp < self.at:
            return None
        self.at = None
        return Spotted(frame.end, 9.0, self.is_sent)

    def best(self, since, until=0):
        return self.score

    def reset(self):
        """Nothing."""


def make(
    mode=Mode.ACTIVE,
    recognizer=None,
    detector=None,
    observer=ignore,
    config=None,
    spotting=None,
    gate=None,
    stop_in_sound=None,
    **changes,
):
    """A pipeline and its clock; `changes` are settings."""
    clock, config = StreamClock(), config or load_voice_config(**changes)
    networks = recognizer or FakeRecognizer(), detector or make_detector()
    fusion = StopFusion(config.spotter, spotting)
    pipeline = Pipeline(config, *networks, clock, fusion, observer, gate, stop_in_sound)
    pipeline.set_mode(mode, "test")
    return pipeline, clock


def run(pipeline, clock, sound):
    """All events of some frames."""
    events = []
    for frame in sound:
        clock.now = frame.end
        events += pipeline(frame)
    return events


def hear(text, mode=Mode.ACTIVE, recognizer=None, **rest):
    """All events of a sentence."""
    return run(*make(mode, recognizer, **rest), frames(say(text)))


def decisions(events):
    """What was decided."""
    return [event for event in events if isinstance(event, UtteranceDecision)]


def actions(events):
    """What is to be done."""
    return [action for decision in decisions(events) for action in decision.actions]


def commands(events):
    """Commands that were taken."""
    return [d.outcome.command for d in decisions(events) if isinstance(d.outcome, Match)]


def refusals(events):
    """Outcomes that are no command."""
    return [d.outcome for d in decisions(events) if isinstance(d.outcome, NoMatch)]

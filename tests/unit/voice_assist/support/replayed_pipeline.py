# SPDX-License-Identifier: BSD-3-Clause
"""A live pipeline with the notes of its side inputs, and its replay from them."""

from dataclasses import dataclass

import numpy as np

from tests.unit.voice_assist.support.fake_speech import FakeRecognizer, make_detector
from voice_assist.config import load_voice_config
from voice_assist.intent.dialogue import Answered
from voice_assist.pipeline.pipeline import Pipeline
from voice_assist.replay.replayer import PipelineReplay
from voice_assist.side_inputs import SideInput, SideInputKind, SideInputs, from_text, to_text
from voice_assist.spotter.fusion import StopFusion
from voice_assist.types import FULL_SCALE, Match, UtteranceDecision

CONFIG = load_voice_config()


@dataclass(frozen=True, eq=False)
class Block:
    """What the topic holds of a frame."""

    samples: np.ndarray
    rate: int
    first_sample: int
    stamp: float


def recorded(frame):
    scaled = np.rint(np.clip(frame.samples, -1.0, 1.0) * FULL_SCALE).astype(np.int16)
    return Block(scaled, 16_000, frame.first_sample, frame.stamp)


class Live:
    """The node's loop around a pipeline, on a machine that is late whenever a test says so."""

    def __init__(self, late=lambda frame: 0.0, unheard=lambda frame: False, spotter=None):
        self.now, self.late, self.unheard = 0.0, late, unheard
        self.notes, self.decisions, self.blocks = [], [], []
        second = StopFusion(CONFIG.spotter, spotter)
        self.recognizer = FakeRecognizer()
        args = self.recognizer, make_detector(), lambda: self.now, second, self.observe
        self.pipeline = Pipeline(CONFIG, *args)

    def observe(self, side_input):
        self.notes.append(to_text(side_input))

    def hear(self, sound):
        for frame in sound:
            self.blocks.append(recorded(frame))
            if self.unheard(frame):
                self.observe(SideInput(SideInputKind.UNHEARD, frame.first_sample))
                continue
            self.now = frame.end + self.late(frame)
            found = [e for e in self.pipeline(frame) if isinstance(e, UtteranceDecision)]
            self.decisions += found
            for decision in found:
                if isinstance(decision.outcome, Match) and decision.outcome.command == "tense":
                    self.pipeline.answer(Answered("tense", False, "nothing is grasped"))
        return self


def again(live, notes=None, spotter=None, recognizer=None):
    """The same sound by way of the recording."""
    past = SideInputs(map(from_text, live.notes if notes is None else notes))
    replayed = FakeReplay(CONFIG, recognizer or FakeRecognizer(), spotter, past)
    return [heard for block in live.blocks for heard in replayed.hear(block)]


class FakeReplay(PipelineReplay):
    """With an endpointing that needs no network."""

    def _build(self, recognizer):
        second = StopFusion(self._config.spotter, self._spotter)
        return Pipeline(self._config, recognizer, make_detector(), lambda: self._now, second)


SAME = ("confidence", "decided_by", "is_partial", "speech_start", "speech_end")


def _seen(one, *facts):
    return (*facts, *(getattr(one, name) for name in SAME))


def as_decided(decisions):
    return [
        _seen(d, d.hypothesis.text, d.command or d.rejection.words, d.outcome.wer, d.mode.value)
        for d in decisions
    ]


def as_heard(heard):
    return [_seen(h, h.transcript, h.command or h.reason, h.wer, h.mode) for h in heard]

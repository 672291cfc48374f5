# SPDX-License-Identifier: BSD-3-Clause
import numpy as np
import pytest

from tests.unit.voice_assist.support.fake_speech import FakeRecognizer
from voice_assist.config import load_voice_config
from voice_assist.pipeline.partial_decoding import PartialDecoder
from voice_assist.types import RATE, Frame, Hypothesis, Utterance, frozen_samples
from voice_assist.vad.segmenter import PartialUtterance

PINNED = {
    "recognizer__early__partial_interval": 0.096,
    "recognizer__early__settle": 0.096,
    "recognizer__early__pause": 0.16,
    "recognizer__early__silence_added": 0.0,
}
EARLY = load_voice_config(**PINNED).recognizer.early
FRAME = 0.032


class Rig:
    """Feeds a hearing with frames of speech and quiet."""

    def __init__(self, early=EARLY):
        self.recognizer = FakeRecognizer()
        self.now = 0.0
        self.late = 0.0
        self.quiet = 0.0
        self.speech_end = 0.0
        self.notes = []
        clock = lambda: self.now + self.late  # noqa: E731
        self.hearing = PartialDecoder(self.recognizer, early, clock, self.notes.append)

    def feed(self, is_speech, is_complete=False, seconds=None):
        """One frame; gives whether something can be decided."""
        self.now += FRAME
        self.quiet = 0.0 if is_speech else self.quiet + FRAME
        self.speech_end = self.now if is_speech else self.speech_end
        samples = frozen_samples(np.zeros(round((seconds or self.now) * RATE)))
        utterance = Utterance(samples, 0.0, self.speech_end, is_complete)
        frame = Frame(samples[:512], 0, self.now - FRAME)
        self.growth = PartialUtterance(utterance, self.quiet, True, 1.0)
        return self.hearing(self.growth, frame, self.now)

    def slow_down(self, cost):
        """Let each pass take so long [s]; gives when they begin."""
        begun, transcribe = [], self.recognizer.transcribe

        def slowly(*given):
            self.late += cost
            begun.append(self.now)
            return transcribe(*given)

        self.recognizer.transcribe = slowly
        return begun

    def hear(self, *lengths):
        """So many frames of speech, then so many of quiet, and so on; gives the turns."""
        return [self.feed(n % 2 == 0) for n, many in enumerate(lengths) for _ in range(many)]

    @property
    def passes(self):
        return len(self.recognizer.heard)


def test_passes_are_an_interval_apart_while_there_is_speech():
    rig = Rig()
    rig.hear(31)
    assert rig.passes == 10


def test_in_the_pause_there_is_one_pass_and_one_turn_and_none_is_new_at_the_end():
    rig = Rig()
    turns = rig.hear(4, 8)
    assert turns[3] and turns[6] and turns[8]
    assert sum(turns) == 3
    assert rig.passes == 2
    assert rig.hearing.is_settled(rig.growth)
    assert rig.feed(False, is_complete=True)
    assert rig.passes == 2


def test_silence_is_put_behind_the_settled_pass_alone():
    added = load_voice_config(**{**PINNED, "recognizer__early__silence_added": 0.15})
    rig = Rig(added.recognizer.early)
    rig.hear(4, 3)
    assert rig.recognizer.heard == pytest.approx([4 * FRAME, 7 * FRAME + 0.15], abs=1e-3)


def test_speech_after_a_pause_is_decoded_again():
    rig = Rig()
    rig.hear(4, 6, 4)
    assert rig.passes == 4


def test_far_behind_the_stream_only_the_pause_is_decoded():
    rig = Rig()
    rig.late = 1.0
    turns = rig.hear(20, 8)
    assert turns.index(True) == 24 and sum(turns) == 1  # after 0.16 s of quiet
    assert rig.passes == 1
    assert rig.feed(False, is_complete=True)
    assert rig.passes == 1


def test_what_fell_behind_is_not_decided_on_by_half_of_its_sound():
    rig = Rig()
    rig.hear(4)
    rig.late = 1.0
    assert rig.hear(3, 5) == [False] * 7 + [True]
    assert rig.recognizer.heard == pytest.approx([4 * FRAME, 12 * FRAME], abs=1e-3)


def test_long_utterances_are_heard_through_a_window():
    rig = Rig()
    for _ in range(4):
        rig.feed(True, seconds=6.0)
    assert rig.feed(False, is_complete=True, seconds=6.0)
    assert rig.recognizer.heard == [EARLY.window, EARLY.window]
    assert rig.hearing.is_window


def test_scores_are_computed_once_for_a_pass():
    rig = Rig()
    rig.hear(4)
    first = rig.hearing.scores(("tense", "stop"))
    assert rig.hearing.scores(("tense", "stop")) is first
    rig.hear(4)
    assert rig.hearing.scores(("tense", "stop")) is not first


def test_the_tail_of_a_word_after_a_decision_is_not_decoded():
    rig = Rig()
    rig.hear(4)
    rig.hearing.restart(rig.growth)
    passes = rig.passes
    assert not any(rig.hear(5, 6))
    assert rig.passes == passes
    rig.hear(8)
    assert rig.passes > passes


def test_without_early_decisions_only_the_end_is_decoded():
    rig = Rig(load_voice_config(**PINNED, recognizer__early__is_enabled=False).recognizer.early)
    assert not any(rig.hear(20, 8)) and rig.passes == 0
    assert rig.feed(False, is_complete=True)
    assert rig.recognizer.heard == [pytest.approx(29 * FRAME, abs=1e-3)]


def test_each_pass_may_ask_what_is_hopeless():
    rig = Rig()
    asked = []

    def transcribe(samples, is_hopeless):
        asked.append(is_hopeless("the patient "))
        return Hypothesis("the patient", 0.0, 0.0)

    rig.recognizer.transcribe = transcribe
    begins = lambda text: text.startswith("the ")  # noqa: E731
    rig.hearing = PartialDecoder(rig.recognizer, EARLY, lambda: rig.now, is_hopeless=begins)
    rig.hear(8)
    assert asked and all(asked)


@pytest.mark.parametrize(("cost", "apart"), [(0.09, 0.096), (0.2, 0.2 / 0.33), (0.45, 0.45 / 0.33)])
def test_a_slow_model_is_asked_less_often_and_what_it_skips_is_noted(cost, apart):
    rig = Rig()
    begun = rig.slow_down(cost)
    for _ in range(250):
        rig.feed(True)
        rig.late = max(rig.late - FRAME, 0.0)  # frames queue while it works
    gaps = np.diff(begun)[2:]  # three slow ones make a model slow
    assert gaps.min() >= apart - 1e-6 and gaps.max() <= apart + FRAME
    is_slow = cost > EARLY.partial_interval
    assert bool(rig.notes) == is_slow


def test_the_end_of_an_utterance_waits_for_no_slow_model():
    rig = Rig()
    rig.slow_down(0.4)
    rig.hear(4)
    assert rig.passes == 1
    rig.feed(True)
    assert rig.feed(False, is_complete=True) and rig.passes == 2

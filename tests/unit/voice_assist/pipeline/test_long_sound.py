# SPDX-License-Identifier: BSD-3-Clause
"""The pipeline in long talk, long noise and lost sound, and how often it transcribes."""

import itertools

import numpy as np
import pytest

from tests.unit.voice_assist.support.fake_pipeline import (
    commands,
    decisions,
    hear,
    make,
    refusals,
    run,
)
from tests.unit.voice_assist.support.fake_speech import FakeRecognizer, frames, say, silence
from voice_assist.types import Hypothesis, Lost, Partial, never_hopeless


def test_partials_grow_and_end_empty():
    events = [e for e in hear("he said release what") if isinstance(e, Partial)]
    texts = [event.text for event in events]
    assert texts[-1] == ""
    assert texts[-2] == "he said release what"
    assert all(b.startswith(a) for a, b in itertools.pairwise(texts[:-1]))


LOST = 4800  # samples


@pytest.mark.parametrize(("quiet", "taken"), [(0.05, []), (1.0, ["pull more"])])
def test_lost_sound_is_reported_and_the_rest_of_a_sentence_does_not_move_but_after_quiet(
    quiet, taken
):
    first = frames(say("do not", after=0.0))
    rest = frames(say("pull more", before=quiet), first[-1].next_sample + LOST)
    events = run(*make(), [*first, *rest])
    assert commands(events) == taken
    ((at, lost),) = ((i, e) for i, e in enumerate(events) if isinstance(e, Lost))
    assert lost.samples == LOST
    assert events[at - 1] == Partial("", lost.stamp)  # what was shown is taken back


def test_talk_longer_than_the_limit_is_cut_and_its_rest_does_not_move():
    talk = "he said what is the " * 7  # 8.75 s in one breath
    for extra in range(4):
        events = hear(talk + "the " * extra + "0.3 release")
        assert commands(events) == []


def test_long_talk_is_heard_through_a_window_and_is_no_command():
    recognizer = FakeRecognizer()
    events = hear("he said what is the " * 6, recognizer=recognizer)
    assert max(recognizer.heard) <= 4.2
    assert commands(events) == [] and len(refusals(events)) == 1


def clicks(seconds):
    """So dense that endpointing takes them for speech."""
    click = np.concatenate([say("mumble", 0.0, 0.0)[:1000], np.zeros(600, np.float32)])
    return np.tile(click, round(seconds * 10))


def noisy(text, before, after, *more):
    """Sentences in one noise, which lasts `after` [s] behind each."""
    parts = [silence(0.5), clicks(before)]
    for one in (text, *more):
        parts += [say(one, 0.12, 0.12), clicks(after)]
    return frames(np.concatenate([*parts, silence(1.0)]).astype(np.float32))


@pytest.mark.parametrize("before", [0.5, 1.4, 2.9, 3.3, 7.6, 8.2, 12.0])
@pytest.mark.parametrize("text", ["stop", "pull more"])
def test_a_command_between_long_noise_is_heard(text, before):
    assert commands(run(*make(), noisy(text, before, 6.0))) == [text]


@pytest.mark.parametrize("between", [2.0, 6.0, 20.0])
@pytest.mark.parametrize(
    "words", [("hey robot", "pull more"), ("stop", "stop"), ("stop", "hey robot", "stop")]
)
def test_each_command_in_one_long_noise_is_heard(words, between):
    events = run(*make(), noisy(words[0], 3.0, between, *words[1:]))
    assert commands(events) == list(words)


def test_the_end_of_a_sentence_with_less_noise_in_it_is_none():
    events = run(*make(), noisy("pull more", 3.0, 0.8, "is what he said"))
    assert "is what he said" not in commands(events)
    assert commands(run(*make(), noisy("he said", 3.0, 0.3, "pull more"))) == []


class Lapsing(FakeRecognizer):
    """Hears nothing in the first pass over a word."""

    def __init__(self, word):
        super().__init__()
        self.word, self.lapses = word, 0

    def transcribe(self, samples, is_hopeless=never_hopeless):
        heard = super().transcribe(samples, is_hopeless)
        if self.word in heard.text and not self.lapses:
            self.lapses += 1
            return Hypothesis("", -1.5, 1.0)
        return heard


@pytest.mark.parametrize("pause", ["0.25", "0.3", "0.35"])
@pytest.mark.parametrize("words", range(4, 17, 3))
def test_talk_in_which_one_pass_hears_nothing_stays_one_utterance(words, pause):
    talk = ["he", "said", "what", "the", "mumble", "is", "now", "the"] * 2
    recognizer = Lapsing("release")
    events = hear(" ".join([*talk[:words], pause, "release"]), recognizer=recognizer)
    assert recognizer.lapses == 1
    assert commands(events) == []
    assert len(refusals(events)) == 1


@pytest.mark.parametrize("is_early", [True, False])
def test_noise_alone_costs_little_and_does_nothing(is_early):
    recognizer = FakeRecognizer()
    made = make(recognizer=recognizer, recognizer__early__is_enabled=is_early)
    assert not decisions(run(*made, noisy("", 20.0, 0.0)))
    assert not is_early or max(recognizer.heard) < 2.2


def test_nothing_is_transcribed_in_quiet_or_twice():
    recognizer = FakeRecognizer()
    run(*make(recognizer=recognizer), frames(say("tense", after=3.0)))
    assert len(recognizer.heard) <= 6  # 3 partials, the pause, its score


def test_a_slow_recogniser_skips_partials_and_still_decides_in_the_pause():
    recognizer = FakeRecognizer()
    pipeline, clock = make(recognizer=recognizer)
    events = []
    for frame in frames(say("pull more")):
        clock.now = frame.end + 2.0  # always two seconds behind
        events += pipeline(frame)
    assert commands(events) == ["pull more"]
    assert len(set(recognizer.heard)) == 1  # one sound, for its text and its scores
    assert [d.is_partial for d in decisions(events)] == [True]

# SPDX-License-Identifier: BSD-3-Clause
"""Amounts through the pipeline: scores of the other numbers, the question, and "stop"."""

from dataclasses import replace

import pytest

from tests.unit.voice_assist.support.fake_pipeline import actions, commands, decisions, make, run
from tests.unit.voice_assist.support.fake_speech import FakeRecognizer, frames, say
from voice_assist.types import Ask, Call, Halt, Mode, RejectionReason

SAID_AS = {  # words of amounts, and the words of the tones in whose place they are heard
    **{"one": "now", "two": "is", "three": "what", "half": "said", "a": "never", "nine": "do"},
    **{"millimetres": "he", "newton": "pulling", "point": "mumble", "tension": "the"},
    **{"yes": "please"},
}
TWO, THREE = "pull two millimetres more", "pull three millimetres more"


class NumbersHeard(FakeRecognizer):
    """Hears words of amounts in tones that stand for other words elsewhere."""

    def transcribe(self, samples, *args):
        heard = super().transcribe(samples, *args)
        meant = {tone: word for word, tone in SAID_AS.items()}
        return replace(heard, text=" ".join(meant.get(w, w) for w in heard.text.split()))


def tones(text):
    return frames(say(" ".join(SAID_AS.get(word, word) for word in text.split())))


def hear(text, recognizer=None, mode=Mode.ACTIVE):
    pipeline, clock = make(mode, recognizer or NumbersHeard(), commands__amounts=True)
    return run(pipeline, clock, tones(text))


def test_an_amount_is_sent_with_its_command_and_unit():
    events = hear(f"0.3 {TWO}")
    assert commands(events) == [TWO]
    assert actions(events) == [Call("pull more 2 mm")]
    assert actions(hear("0.3 half a newton less")) == [Call("pull less 0.5 N")]


def test_a_sound_that_is_more_like_another_number_does_nothing():
    events = hear(f"0.3 {TWO}", NumbersHeard(scores={TWO: -1.0, THREE: 1.0}))
    (decision,) = decisions(events)
    assert decision.rejection.reason is RejectionReason.SOUNDS_LIKE_ANOTHER
    assert decision.rejection.words == f"it sounds more like {THREE!r}"


def test_a_large_amount_is_asked_for_though_it_is_sure():
    events = hear(f"0.3 {THREE} 1.0 yes")
    assert actions(events) == [Ask(THREE), Call("pull more 3 mm")]
    asked = decisions(events)[0].rejection
    assert asked.reason is RejectionReason.NEARLY_SURE
    assert asked.words == 'a large amount; say "yes" within 3 s: 3 mm, done at once: up to 2'


@pytest.mark.parametrize("then", ["", "4.0 yes", "1.0 yes more", "1.0 stop 0.5 yes"])
def test_a_large_amount_without_its_yes_does_nothing(then):
    assert Call("pull more 3 mm") not in actions(hear(f"0.3 {THREE} {then}"))


def test_a_large_amount_by_hand_is_confirmed_by_its_name():
    pipeline, clock = make(recognizer=NumbersHeard(), commands__amounts=True)
    run(pipeline, clock, tones(f"0.3 {THREE}"))
    assert pipeline.answer_by_hand(THREE, is_yes=True) == (Call("pull more 3 mm"),)


def test_an_amount_that_is_none_of_the_slots_does_nothing_nor_any_in_standby():
    events = hear("0.3 pull nine millimetres more")
    assert actions(events) == []
    assert decisions(events)[0].rejection.words.startswith("'nine millimetres' is not among")
    events = hear(f"0.3 {TWO}", mode=Mode.STANDBY)
    assert actions(events) == []
    assert decisions(events)[0].rejection.reason is RejectionReason.WRONG_MODE


@pytest.mark.parametrize("text", ["pull two stop", f"{TWO} stop", "tension one point stop"])
def test_stop_within_an_amount_stops(text):
    events = hear(f"0.3 {text}", NumbersHeard(confidence=0.95))
    assert actions(events) == [Halt(), Call("stop")]

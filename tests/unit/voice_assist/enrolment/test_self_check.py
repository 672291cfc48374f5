# SPDX-License-Identifier: BSD-3-Clause
"""The check of a profile where motions are to be said twice, with a recogniser that never errs."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from tests.unit.voice_assist.support.fake_speech import FakeRecognizer, make_detector, say
from voice_assist.config import load_voice_config
from voice_assist.config.enrolment import load_enrolment_config
from voice_assist.enrolment import pipeline_probe, self_check
from voice_assist.enrolment.build import _plain as plain
from voice_assist.enrolment.learn import EnrolmentMaterial, LabelledTake
from voice_assist.enrolment.self_check import SelfCheck
from voice_assist.pipeline.pipeline import Pipeline
from voice_assist.profile.spellings import Spelled, Spellings
from voice_assist.types import never_hopeless

OTHER = {"pull more": "pull less", "pull less": "pull more"}


class Swapped(FakeRecognizer):
    """Hears the one motion for the other."""

    def transcribe(self, samples, is_hopeless=never_hopeless):
        heard = super().transcribe(samples, is_hopeless)
        return replace(heard, text=OTHER.get(heard.text, heard.text))


@pytest.fixture
def strangers():
    """How other voices were asked for."""
    return []


@pytest.fixture
def check(monkeypatch, strangers):
    """Check takes, each of a phrase and what is said in it, by what was learned to be `learned`."""
    make = lambda config, clock, heard: Pipeline(config, heard, make_detector(), clock)  # noqa: E731
    monkeypatch.setattr(pipeline_probe, "make_pipeline", make)
    monkeypatch.setattr(self_check, "learn", lambda *_: SimpleNamespace(state=None))

    def other_voices(phrases, count, seed, **given):
        strangers.append(given)
        return []

    monkeypatch.setattr(self_check, "other_voices", other_voices)

    def check(learned, said, written=()):
        monkeypatch.setattr(self_check, "PersonalRecognizer", lambda *_: learned)
        voice = plain(load_voice_config(commands__said_twice=True))
        takes = (LabelledTake(text, phrase, say(text, 0.1, 0.1)) for phrase, text in said)
        material = EnrolmentMaterial(tuple(takes), ())
        run = SelfCheck(voice, load_enrolment_config(), FakeRecognizer())
        return run(material, Spellings(commands=written), learned, [])

    return check


@pytest.fixture
def problems_of(check):
    """Problems of a profile that was learned to be a recogniser."""
    said = [(phrase, phrase) for phrase in OTHER for _ in range(3)]
    return lambda learned: check(learned, said).problems(load_enrolment_config())


def test_a_profile_that_swaps_two_motions_is_refused(problems_of):
    takes, confused = problems_of(Swapped())
    assert takes.startswith("takes: 0 of 6 right, allowed: at least ")
    assert confused.startswith("takes for another command: 6, ")


def test_a_profile_that_hears_as_its_base_is_taken(problems_of):
    assert problems_of(FakeRecognizer()) == ()


def right(trials):
    return [trial.profile == (trial.phrase,) for trial in trials]


def test_a_take_is_heard_by_spellings_of_other_takes_alone(check):
    odd = "mumble please"
    spelled = (Spelled(phrase="tense", learned=(odd,)),)  # from all takes
    once = [("tense", odd), ("tense", "tense"), ("tense", "tense")]
    assert right(check(FakeRecognizer(), once, spelled).own) == [False, True, True]
    assert right(check(FakeRecognizer(), [("tense", odd)] * 3).own) == [True, True, True]


def test_the_other_voices_of_the_check_are_none_that_training_heard(check, strangers):
    check(FakeRecognizer(), [("tense", "tense")] * 3)
    assert strangers == [{"are_held_out": True}]

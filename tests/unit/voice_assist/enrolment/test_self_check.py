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
from voice_assist.types import never_hopeless

OTHER = {"pull more": "pull less", "pull less": "pull more"}


class Swapped(FakeRecognizer):
    """Hears the one motion for the other."""

    def transcribe(self, samples, is_hopeless=never_hopeless):
        heard = super().transcribe(samples, is_hopeless)
        return replace(heard, text=OTHER.get(heard.text, heard.text))


@pytest.fixture
def problems_of(monkeypatch):
    """Problems of a profile that was learned to be a recogniser."""
    make = lambda config, clock, heard: Pipeline(config, heard, make_detector(), clock)  # noqa: E731
    monkeypatch.setattr(pipeline_probe, "make_pipeline", make)
    monkeypatch.setattr(self_check, "learn", lambda *_: SimpleNamespace(state=None))
    monkeypatch.setattr(self_check, "other_voices", lambda *_: [])
    said = [LabelledTake(f"{p} {n}", p, say(p, 0.1, 0.1)) for p in OTHER for n in range(3)]

    def problems(learned):
        monkeypatch.setattr(self_check, "PersonalRecognizer", lambda *_: learned)
        voice = plain(load_voice_config(commands__said_twice=True))
        config = load_enrolment_config()
        check = SelfCheck(voice, config, FakeRecognizer())
        result = check(EnrolmentMaterial(tuple(said), ()), voice, learned, [])
        return result.problems(config)

    return problems


def test_a_profile_that_swaps_two_motions_is_refused(problems_of):
    takes, confused = problems_of(Swapped())
    assert takes.startswith("takes: 0 of 6 right, allowed: at least ")
    assert confused.startswith("takes for another command: 6, ")


def test_a_profile_that_hears_as_its_base_is_taken(problems_of):
    assert problems_of(FakeRecognizer()) == ()

# SPDX-License-Identifier: BSD-3-Clause
import math
from dataclasses import replace

import pytest

from tests.unit.voice_assist.support.fake_pipeline import FakeSpotting
from voice_assist.config import load_voice_config
from voice_assist.intent.early_decision import DecisionContext, EarlyDecision
from voice_assist.intent.mapper import Mapper
from voice_assist.spotter.fusion import StopFusion
from voice_assist.types import Hypothesis, Match

CONFIG = load_voice_config(
    recognizer__early__pause=0.16,
    recognizer__early__unchanged_for=0.8,
    recognizer__early__stop_agreement=2,
    recognizer__early__vote_confidence=0.7,
    recognizer__early__first_stop_confidence=0.9,
)


UNHEARD = -20.0  # [nat] of the spotter


def judging(spotting=None):
    fusion = StopFusion(CONFIG.spotter, spotting)
    return EarlyDecision(Mapper(CONFIG.commands), CONFIG.commands, CONFIG.recognizer.early, fusion)


@pytest.fixture
def judge():
    return judging()


def heard(text, confidence=0.8):
    return Hypothesis(text, math.log(confidence), 0.0)


LEAST = CONFIG.commands.get("stop").min_confidence


def at(time, has_paused=False, is_complete=False, is_whole=True):
    return DecisionContext(time, has_paused, is_complete, is_whole)


@pytest.mark.parametrize(
    ("readings", "then"),
    [
        (["stop", "stock", "stop"], heard("stop")),  # two in a row
        ([], heard("stop", 0.95)),  # one that is sure
    ],
)
def test_stop_needs_two_readings_in_a_row_or_a_sure_one(judge, readings, then):
    for number, text in enumerate(readings, 1):
        assert judge(heard(text), at(0.1 * number)) is None
    assert judge(then, at(0.4)).command == "stop"


@pytest.mark.parametrize(
    ("text", "confidence", "before"),
    [("stop", 0.8, 0), ("stop", LEAST + 0.01, 3), ("pull more", 0.8, 2)],  # half sure; a motion
)
def test_in_a_pause_one_reading_is_enough(judge, text, confidence, before):
    for number in range(before):
        assert judge(heard(text, confidence), at(0.1 * (number + 1))) is None
    assert judge(heard(text, confidence), at(0.7, has_paused=True)).command == text


def test_unsure_readings_of_stop_do_not_count(judge):
    for time in (0.1, 0.2, 0.3):
        assert judge(heard("stop", 0.3), at(time)) is None
    refused = judge(heard("stop", 0.3), at(0.8, True, is_complete=True))
    assert refused.rejection.words == f"confidence 0.30, allowed: at least {LEAST:.2f}"


@pytest.mark.parametrize(
    ("is_moving", "then", "is_stop"),
    [(False, "stop the pump", False), (False, "stop", True), (True, "stop the pump", True)],
)
def test_what_only_the_recogniser_hears_stops_in_motion_at_once_and_at_rest_in_a_pause(
    is_moving, then, is_stop
):
    judge = judging(FakeSpotting(UNHEARD))
    moments = [("stop", at(0.1)), ("stop", at(0.2)), (then, at(0.5, has_paused=True))]
    said = [
        judge(heard(text, 0.95), replace(moment, spotted=UNHEARD, is_moving=is_moving))
        for text, moment in moments
    ]
    assert any(isinstance(one, Match) for one in said) == is_stop
    assert isinstance(said[0], Match) == is_moving


def test_at_rest_noise_behind_a_stop_that_only_the_recogniser_hears_delays_it_for_a_while():
    judge = judging(FakeSpotting(UNHEARD))
    said = [judge(heard("stop", 0.95), replace(at(t), spotted=UNHEARD)) for t in (0.1, 0.5, 0.9)]
    assert [isinstance(one, Match) for one in said] == [False, False, True]


def test_after_a_stop_there_is_no_second_one(judge):
    judge.accept("stop")
    assert judge(heard("stop", 0.99), at(0.5, True, is_complete=True)) is None


def test_a_motion_that_stays_while_noise_goes_on_is_taken_in_the_end(judge):
    times = [0.5 + 0.1 * i for i in range(12)]
    taken = [judge(heard("pull more"), at(time)) for time in times]
    assert taken[0] is None and taken[7] is None
    assert taken[-1].command == "pull more"


def test_a_new_word_starts_the_wait_anew(judge):
    judge(heard("pull more"), at(0.5))
    judge(heard("pull more is"), at(1.0))
    judge(heard("pull more"), at(1.1))
    assert judge(heard("pull more"), at(1.4)) is None


def test_the_rest_of_an_utterance_cannot_move_but_can_stop(judge):
    refused = judge(heard("release"), at(1.0, True, is_complete=True, is_whole=False))
    assert "continues a longer utterance" in refused.rejection.words
    assert judge(heard("release"), at(1.0, True, is_whole=False)) is None
    assert isinstance(judge(heard("stop"), at(1.0, True, is_whole=False)), Match)


def test_after_a_command_the_reason_names_it(judge):
    judge.accept("hey robot")
    refused = judge(heard("tense"), at(1.0, True, is_complete=True, is_whole=False))
    assert refused.rejection.words.startswith("it continues 'hey robot' in the same breath")


def test_nothing_said_is_nothing_and_a_new_utterance_forgets_the_last(judge):
    assert judge(heard(""), at(1.0, True, is_complete=True)) is None
    judge.accept("hey robot")
    judge.accept("stop")
    judge.reset()
    assert not judge.has_decided
    assert judge(heard("tense"), at(0.5, 0.16)).command == "tense"

# SPDX-License-Identifier: BSD-3-Clause
import math

import pytest

from voice_assist.config import load_voice_config
from voice_assist.intent.early_decision import DecisionContext, EarlyDecision
from voice_assist.intent.mapper import Mapper
from voice_assist.spotter.fusion import StopFusion
from voice_assist.types import Hypothesis, Match, NoMatch

CONFIG = load_voice_config(
    recognizer__early__pause=0.16,
    recognizer__early__unchanged_for=0.8,
    recognizer__early__stop_agreement=2,
    recognizer__early__vote_confidence=0.7,
    recognizer__early__first_stop_confidence=0.9,
)


@pytest.fixture
def judge():
    alone = StopFusion(CONFIG.spotter, None)
    return EarlyDecision(Mapper(CONFIG.commands), CONFIG.commands, CONFIG.recognizer.early, alone)


def heard(text, confidence=0.8):
    return Hypothesis(text, math.log(confidence), 0.0)


def at(time, has_paused=False, is_complete=False, is_whole=True):
    return DecisionContext(time, has_paused, is_complete, is_whole)


def test_stop_needs_two_readings_in_a_row(judge):
    assert judge(heard("stop"), at(0.1)) is None
    assert judge(heard("stock"), at(0.2)) is None
    assert judge(heard("stop"), at(0.3)) is None
    assert judge(heard("stop"), at(0.4)).command == "stop"


def test_one_sure_reading_of_stop_is_enough(judge):
    assert judge(heard("stop", 0.95), at(0.1)).command == "stop"


def test_one_reading_of_stop_is_enough_in_a_pause(judge):
    assert judge(heard("stop"), at(0.5, has_paused=True)).command == "stop"


def test_unsure_readings_of_stop_do_not_count(judge):
    for time in (0.1, 0.2, 0.3):
        assert judge(heard("stop", 0.3), at(time)) is None
    refused = judge(heard("stop", 0.3), at(0.8, True, is_complete=True))
    least = CONFIG.commands.get("stop").min_confidence
    assert refused.rejection.words == f"confidence 0.30, allowed: at least {least:.2f}"


def test_a_half_sure_stop_waits_for_the_pause(judge):
    least = CONFIG.commands.get("stop").min_confidence
    for time in (0.1, 0.2, 0.3):
        assert judge(heard("stop", least + 0.01), at(time)) is None
    assert judge(heard("stop", least + 0.01), at(0.5, has_paused=True)).command == "stop"


def test_after_a_stop_there_is_no_second_one(judge):
    judge.accept("stop")
    assert judge(heard("stop", 0.99), at(0.5, True, is_complete=True)) is None


def test_a_motion_waits_for_the_pause(judge):
    assert judge(heard("pull more"), at(0.5)) is None
    assert judge(heard("pull more"), at(0.6)) is None
    assert judge(heard("pull more"), at(0.7, has_paused=True)).command == "pull more"


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


def test_the_rest_of_an_utterance_cannot_move(judge):
    refused = judge(heard("release"), at(1.0, True, is_complete=True, is_whole=False))
    assert (
        isinstance(refused, NoMatch) and "continues a longer utterance" in refused.rejection.words
    )
    assert judge(heard("release"), at(1.0, True, is_whole=False)) is None


def test_the_rest_of_an_utterance_can_stop(judge):
    assert isinstance(judge(heard("stop"), at(1.0, True, is_whole=False)), Match)


def test_after_a_command_the_reason_names_it(judge):
    judge.accept("hey robot")
    refused = judge(heard("tense"), at(1.0, True, is_complete=True, is_whole=False))
    assert refused.rejection.words.startswith("it continues 'hey robot' in the same breath")


def test_nothing_said_is_nothing(judge):
    assert judge(heard(""), at(1.0, True, is_complete=True)) is None


def test_a_new_utterance_forgets_the_last(judge):
    judge.accept("hey robot")
    judge.accept("stop")
    judge.reset()
    assert not judge.has_decided
    assert judge(heard("tense"), at(0.5, 0.16)).command == "tense"

# SPDX-License-Identifier: BSD-3-Clause
from dataclasses import replace

import pytest

from session_log.replay.command import REPLAY_CONFIG
from session_log.replay.compare import compare
from session_log.replay.config import ReplayConfig
from tests.unit.session_log.support.fake_pipeline import utterance
from typed_config import load_config, load_yaml

CONFIG = load_config(ReplayConfig, load_yaml(REPLAY_CONFIG), "replay.yaml")
NAN = float("nan")
THREE = [utterance(1.0), utterance(4.0, transcript="stop", command="stop"), utterance(9.0)]


def kinds(recorded, now):
    return [(d.number, d.kinds) for d in compare(recorded, now, CONFIG)]


def test_the_same_utterances_differ_in_nothing():
    assert kinds(THREE, list(THREE)) == []


def test_nothing_then_and_nothing_now_is_the_same():
    assert kinds([], []) == []


@pytest.mark.parametrize("index", [0, 1, 2])
def test_an_utterance_that_is_no_more_heard_is_missing(index):
    now = [entry for k, entry in enumerate(THREE) if k != index]
    assert kinds(THREE, now) == [(index + 1, ("missing",))]


@pytest.mark.parametrize("index", [0, 1, 2, 3])
def test_an_utterance_that_was_not_heard_then_is_extra(index):
    other = utterance([0.1, 2.5, 6.0, 12.0][index], transcript="hello", command="")
    now = [*THREE[:index], other, *THREE[index:]]
    (difference,) = compare(THREE, now, CONFIG)
    assert (difference.number, difference.kinds) == (index, ("extra",))
    assert difference.recorded is None and difference.now is other
    assert difference.decision == other.decision


def test_two_that_change_places_are_one_difference_of_order():
    close = [utterance(1.0), utterance(1.3, transcript="stop", command="stop"), utterance(9.0)]
    found = kinds(close, [close[1], close[0], close[2]])
    assert [k for _, k in found] == [("order",)]


@pytest.mark.parametrize(
    ("change", "kind"),
    [
        ({"transcript": "tents"}, "transcript"),
        ({"command": "release"}, "command"),
        ({"command": "", "reason": "a tie"}, "command"),
        ({"wer": {"tense": 0.5, "stop": 1.0}}, "WER"),
        ({"wer": {"tense": 0.0}}, "WER"),
        ({"confidence": 0.89}, "confidence"),
        ({"confidence": NAN}, "confidence"),
        ({"wer": {"tense": NAN, "stop": 1.0}}, "WER"),
        ({"nearest_command": "stop"}, "nearest_command"),
        ({"mode": "standby"}, "mode"),
        ({"decided_by": "spotter"}, "decided_by"),
        ({"is_partial": True}, "is_partial"),
        ({"speech_start": 3.3}, "start of speech"),
        ({"speech_end": 4.3}, "end of speech"),
    ],
)
def test_each_field_that_differs_is_named(change, kind):
    recorded = [utterance(1.0), utterance(4.0), utterance(9.0)]
    now = [recorded[0], replace(recorded[1], **change), recorded[2]]
    assert kinds(recorded, now) == [(2, (kind,))]


def test_what_is_no_number_then_and_now_is_the_same():
    undecided = replace(THREE[0], confidence=NAN, wer={"tense": NAN})
    assert kinds([undecided], [replace(undecided)]) == []


def test_several_fields_of_one_utterance_are_one_difference():
    changed = replace(THREE[0], transcript="tents", command="", reason="no match", confidence=0.2)
    (difference,) = compare(THREE, [changed, *THREE[1:]], CONFIG)
    assert difference.kinds == ("transcript", "command", "confidence")
    assert (difference.recorded, difference.now) == (THREE[0], changed)


@pytest.mark.parametrize(
    "change",
    [
        {"confidence": 0.9 + 0.9e-3},
        {"wer": {"tense": 1e-8, "stop": 1.0}},
        {"speech_start": 0.509},
        {"speech_end": 1.009},
        {"decision": 1.9},  # that depends on the machine
    ],
)
def test_what_is_within_tolerance_is_the_same(change):
    assert kinds([utterance(1.0)], [utterance(1.0, **change)]) == []


def test_another_reason_differs_but_not_another_number_in_it():
    then = utterance(command="", reason="confidence 0.43, allowed: at least 0.50")
    same = replace(then, reason="confidence 0.44, allowed: at least 0.50")
    other = replace(then, reason="it sounds more like 'stop'")
    assert kinds([then], [same]) == []
    assert kinds([then], [other]) == [(1, ("reason",))]


def test_one_missing_among_many_equal_commands_is_that_one():
    recorded = [utterance(3.0 * k) for k in range(10)]
    assert kinds(recorded, recorded[:4] + recorded[5:]) == [(5, ("missing",))]


def test_what_is_far_apart_is_missing_and_extra():
    found = kinds([utterance(1.0)], [utterance(8.0)])
    assert sorted(found) == [(1, ("extra",)), (1, ("missing",))]


def test_an_extra_one_just_before_does_not_take_the_place_of_the_next():
    recorded = [utterance(5.0, confidence=0.9)]
    now = [utterance(4.5, transcript="uh", command=""), utterance(5.0, confidence=0.8)]
    assert kinds(recorded, now) == [(0, ("extra",)), (1, ("confidence",))]

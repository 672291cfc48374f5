# SPDX-License-Identifier: BSD-3-Clause
"""Counting of trials: verdicts, groups, bounds, latencies, homophones, what fired."""

from types import SimpleNamespace

import pytest
from scipy.stats import binom, poisson

from bench.voice.hearing.pieces import SceneRecord
from bench.voice.hearing.replay_stream import SceneDecision, SceneResult
from bench.voice.no_commands import armed, near_misses, unarmed
from bench.voice.outcomes import (
    SENSE,
    by,
    engine,
    is_opposite,
    latencies,
    motions,
    others,
    right,
    share_of_voices,
    tally,
    verdict,
    voice,
)
from session_log.report.bounds import at_least, at_most
from voice_assist.evaluation.exact_bounds import rate_at_most

MOTIONS = ("tense", "release", "pull more", "pull less")


def said(command, at=1.0, is_taken=True, confidence=0.9, origin="recognizer"):
    return SceneDecision(
        at, command, is_taken, confidence, origin, command, "" if is_taken else "unsure"
    )


def record(text, *decisions, engine="espeak", voice="en-gb-x-gbcwmd+f2", seconds=1.0, **more):
    label = {"text": text, "engine": engine, "voice": voice, "path": "a.wav", "end": 0.9}
    heard = SceneResult(tuple(decisions), seconds + 2.0, 0.1, seconds + 2.0)
    return SceneRecord({**label, "seconds": seconds, **more}, heard)


# --- verdicts


@pytest.mark.parametrize(
    ("text", "taken", "found"),
    [
        ("pull more", ["pull less"], "opposite"),
        ("pull less", ["pull more"], "opposite"),
        ("tense", ["release"], "opposite"),
        ("release", ["tense"], "opposite"),
        ("pull less", ["tense"], "opposite"),
        ("pull more", ["pull more", "pull less"], "opposite"),
        *((end, [motion], "opposite") for end in ("stop", "terminate") for motion in MOTIONS),
        ("tense", ["pull more"], "wrong"),  # of the same sense
        ("release", ["pull less"], "wrong"),
        *((motion, ["stop"], "wrong") for motion in MOTIONS),
        ("hey robot", ["tense"], "wrong"),  # it has no sense to be against
        ("stop", ["stop", "hey robot"], "wrong"),
        ("stop", ["stop"], "right"),
        ("stop", ["stop", "stop"], "right"),
        ("stop", [], "nothing"),
    ],
)
def test_only_a_motion_against_what_was_said_is_opposite_and_only_that_alone_is_right(
    text, taken, found
):
    assert verdict(text, taken) == found


@pytest.mark.parametrize("text", MOTIONS)
def test_an_end_in_place_of_a_motion_is_never_opposite(text):
    assert not is_opposite(text, "terminate")


def test_all_motions_of_the_settings_have_a_sense():
    assert {command for command, sense in SENSE.items() if sense} == motions() == set(MOTIONS)


# --- tallies


def test_tally_counts_opposites_among_the_wrong_and_bounds_exactly():
    records = [record("pull more", said("pull more"))] * 7
    records += [record("pull more", said("pull less")), record("pull more", said("stop"))]
    records += [record("pull more", said("pull more", is_taken=False))]
    found = tally(records)
    assert (found.n, found.right, found.nothing, found.wrong, found.opposite) == (10, 7, 1, 2, 1)
    data = found.to_json()
    assert binom.sf(6, 10, data["right_at_least"]) == pytest.approx(0.05)
    assert binom.cdf(2, 10, data["wrong_at_most"]) == pytest.approx(0.05)
    assert binom.cdf(1, 10, data["opposite_at_most"]) == pytest.approx(0.05)


def test_a_bound_counts_voices_where_few_voices_have_all_misses():
    records = [record("stop", said("stop"), engine=f"engine {i}") for i in range(9)] * 100
    records += [record("stop", engine="the tenth")] * 100
    figure = right("stop", tally(records))
    assert figure.value == 90.0
    alone = 100.0 * at_least(900, 1000)
    assert figure.lower < 80.0 < alone  # two or more of ten voices may be like the tenth
    assert right("stop", tally(records[:900])).lower == pytest.approx(100.0 * at_least(900, 900))


def test_few_voices_that_are_taken_wrongly_widen_the_bound_of_the_opposite_and_of_any_share():
    records = [record("tense", said("tense"), engine=f"engine {i}") for i in range(9)] * 100
    records += [record("tense", said("release"), engine="the tenth")] * 100
    alone = 100.0 * at_most(100, 1000)
    trials = [(voice(r), "release" in r.heard.taken) for r in records]
    found = [*others("x", tally(records)), share_of_voices("x", trials, 0.0, at_most=True)]
    assert [(f.value, f.note) for f in found] == [(10.0, "100 of 1000")] * 3
    assert alone < 20.0 < min(f.upper for f in found)


def test_groups_keep_engines_apart():
    records = [record("stop", said("stop"), engine="pico"), record("stop", engine="mbrola")]
    found = by(records, engine)
    assert (found["pico"].right, found["mbrola"].right) == (1, 0)
    assert list(found) == ["mbrola", "pico"]


def test_one_opposite_misses_its_target_and_none_meets_it():
    wrong, opposite = others("x", tally([record("tense", said("release"))]), targets=True)
    assert (wrong.is_met, opposite.is_met) == (False, False)
    wrong, opposite = others("x", tally([record("tense", said("tense"))]), targets=True)
    assert (wrong.is_met, opposite.is_met) == (True, True)


def test_latency_is_of_the_first_command_taken_in_right_trials_alone():
    records = [
        record("stop", said("stop", 0.5, is_taken=False), said("stop", 1.0), said("stop", 2.0)),
        record("stop", said("tense", 1.0)),
        record("stop"),
    ]
    assert latencies(records) == {"stop": [pytest.approx(100.0)]}


# --- false commands


@pytest.mark.parametrize("events", [0, 1, 9])
def test_bound_on_a_rate_leaves_five_percent_below(events):
    most = rate_at_most(events, 2.5)
    assert poisson.cdf(events, most * 2.5) == pytest.approx(0.05)


def test_false_commands_are_counted_by_hours_of_sound_with_exact_bounds():
    records = [record("", said("stop"), seconds=1800.0), record("", seconds=1800.0)]
    records += [record("", said("tense", is_taken=False), seconds=3600.0)]
    found = {f.name: f for f in armed.of_commands("talk", records, 0.0, 0.5)}
    assert found["talk: false motions"].value == 0
    assert found["talk: false motions"].is_met
    assert found["talk: false stops"].value == pytest.approx(0.5)
    assert found["talk: false stops"].is_met
    bound = found["talk: false stops"].upper
    assert poisson.cdf(1, bound * 2.0) == pytest.approx(0.05)


def test_clips_that_were_heard_again_and_again_bound_a_rate_by_their_length():
    records = [record("", said("stop"), seconds=3600.0)] * 4
    often = {f.name: f for f in armed.of_commands("talk", records, unique=1.0)}["talk: false stops"]
    assert often.value == 1.0 and often.upper == pytest.approx(rate_at_most(1, 1.0))
    assert "1.00 h of clips, heard again and again" in often.note
    once = armed.of_commands("talk", records, unique=5.0)
    assert not any("again" in figure.note for figure in once)


def test_a_false_motion_misses_its_target_and_is_listed_with_who_said_what():
    records = [record("archie", said("tense", confidence=0.7), voice="v"), record("joke")]
    found = armed.of_commands("talk", records, 0.0)
    assert found[0].is_met is False
    assert "tense: 1" in found[0].note
    (fired,) = armed.fired(records)
    assert (fired["taken"], fired["text"], fired["voice"]) == ("tense", "archie", "v")


def test_what_fires_in_talk_is_listed_with_the_utterance_begun_last():
    spans = [(0.5, "suction please", "v", "a"), (3.0, "where is the trocar", "w", "b")]
    talk = record("", said("hey robot", 4.2), spans=spans, who="synthetic", seed=3)
    (fired,) = unarmed.fired(talk)
    assert (fired["said"], fired["voice"]) == ("where is the trocar", "w")


@pytest.mark.parametrize(
    ("taken", "reaches"),
    [
        (["hey robot", "tense"], 1),
        (["stop", "tense", "pull more"], 0),
        (["hey robot", "stop", "tense"], 0),
        (["stop", "hey robot", "tense", "stop", "release"], 1),
        (["stop", "terminate", "tense"], 0),
    ],
)
def test_a_motion_after_a_stop_reaches_no_robot_before_the_next_hey_robot(taken, reaches):
    talk = record("", *(said(command) for command in taken))
    assert unarmed.reaching([talk]) == reaches


def test_a_stop_of_one_piece_of_talk_halts_nothing_in_the_next():
    pieces = [record("", said("stop")), record("", said("tense"))]
    assert unarmed.reaching(pieces) == 1


# --- near misses


def caribbean(text, *decisions):
    return record(text, *decisions, voice="en-029+m1")


def test_what_sounds_the_same_in_its_voice_is_counted_apart():
    records = [
        caribbean("pull moor", said("pull more")),
        caribbean("tents"),
        record("illuminate"),
        record("don't stop"),
    ]
    assert [near_misses.is_same(r) for r in records] == [True, False, False, False]
    found = {f.name: f for f in near_misses.figures(records)}
    assert found["near misses: taken as motion"].value == 0.0
    assert found["near misses: taken as motion"].is_met
    assert found["same sounds as a command: taken as motion"].value == 100.0
    together = "near misses, those that sound the same too: taken as motion"
    assert found[together].value == pytest.approx(25.0)


def test_a_stop_taken_from_a_denied_stop_is_no_motion():
    records = [record("don't stop", said("stop")), record("tents"), record("illuminate")]
    found = {f.name: f for f in near_misses.figures(records)}
    assert found["near misses: taken as motion"].value == 0.0
    assert found["denied: taken as motion"].is_met
    assert found["denied: taken as stop"].value == 100.0
    assert "in a sentence: taken as stop" not in found


def test_a_denied_command_that_moves_misses_its_target():
    records = [record("don't pull more", said("pull more")), record("tents")]
    found = {f.name: f for f in near_misses.figures(records)}
    assert found["denied: taken as motion"].is_met is False
    assert '"don\'t pull more"' in found["denied: taken as motion"].note


def test_phrases_taken_are_listed_motions_first_with_voice_and_confidence():
    records = [record("shop", said("stop")), record("tents", said("tense", confidence=0.62))]
    first, second = near_misses.taken(records)
    assert (first["said"], first["taken"], first["confidence"]) == ("tents", "tense", 0.62)
    assert first["voice"] == "espeak:en-gb-x-gbcwmd+f2"
    assert (first["is_motion"], second["is_motion"]) == (True, False)


def test_the_whole_of_near_misses_does_not_shrink_with_a_thinner_run(monkeypatch):
    monkeypatch.setattr(near_misses, "spoken", list)
    monkeypatch.setattr(near_misses, "spread", lambda *_: [])
    monkeypatch.setattr(near_misses, "natives", lambda: SimpleNamespace(present=()))
    monkeypatch.setattr(near_misses, "measured", lambda: {"phrases": [], "named": []})
    monkeypatch.setattr(near_misses.resumable, "write_details", lambda *_: None)
    wholes = []
    for thin in (1, 3, 6):
        monkeypatch.setattr(near_misses, "THIN", thin)
        wholes.append(near_misses.measure()[0].target)
    assert wholes[0] == 3 * wholes[1] and wholes[1] == wholes[2] > 0

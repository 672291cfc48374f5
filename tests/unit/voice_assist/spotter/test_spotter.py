# SPDX-License-Identifier: BSD-3-Clause

from dataclasses import replace

import numpy as np
import pytest

from support.theatre_sound import speak
from tests.unit.voice_assist.support.fake_pipeline import FakeSpotting, decisions, hear, make
from tests.unit.voice_assist.support.fake_speech import FakeRecognizer, frames
from voice_assist.assembly import make_spotter
from voice_assist.audio.source import FRAME
from voice_assist.config import load_voice_config
from voice_assist.errors import CommandsError
from voice_assist.spotter.features import STEP, Embedder
from voice_assist.spotter.fusion import StopEvidence, StopFusion
from voice_assist.spotter.head import CONTEXT
from voice_assist.spotter.spotter import Spotted, Spotter
from voice_assist.types import RATE, Call, Frame, Halt, Hypothesis, Match, Mode, frozen_samples

CONFIG = load_voice_config(spotter__alone=0.5).spotter  # more sensitive than it is shipped
RULE = load_voice_config(
    spotter__alone=8.0,
    spotter__middle=4.0,
    spotter__agree=1.0,
    spotter__near=3.0,
    spotter__sure=0.9,
)


@pytest.fixture(scope="module")
def spotter():
    found, digest = make_spotter(CONFIG)
    assert len(digest) == 64
    return found


@pytest.fixture
def listen(spotter):
    def run(samples):
        spotter.reset()
        return [s for frame in frames(samples.astype(np.float32)) if (s := spotter(frame))]

    return run


def test_after_the_clock_was_set_back_it_fires_as_ever():
    """What it fired half a minute later, by that clock, holds nothing back."""
    frontend = type("Frontend", (), {"quiet": np.zeros(1), "reset": lambda self: None})()
    frontend.__class__.__call__ = lambda self, samples: [np.zeros(1)]
    eager = Spotter(CONFIG, frontend, lambda seen: 9.0, 1)
    sound = frames(np.zeros(3 * FRAME, np.float32))
    sound = zip(sound, (1000.0, 1000.5, 970.0), strict=True)
    fired = [eager(replace(frame, stamp=stamp)) is not None for frame, stamp in sound]
    assert fired == [True, False, True]


def test_after_the_clock_was_set_back_a_spotted_stop_is_taken():
    stops = make()[0]._decider.stops
    stops._halted_until = 1000.0
    times = (1000.5, 999.9, 970.0)  # the thread of the spotter is a little late
    taken = [stops.spotted(Spotted(time, 9.0)) is not None for time in times]
    assert taken == [False, False, True]


def spoken(words, voice="en-us"):
    sound = speak(words, voice, 175)
    loud = 0.3 * sound / np.abs(sound).max()
    quiet = 2e-4 * np.random.default_rng(0).standard_normal(3 * RATE + len(loud))
    quiet[RATE : RATE + len(loud)] += loud
    return quiet


@pytest.mark.parametrize("voice", ["en-us", "en-gb"])
def test_a_spoken_stop_fires_once(listen, voice):
    assert len(listen(spoken("stop", voice))) == 1


@pytest.mark.parametrize("words", ["release", "pull more", "hello there", "good morning everyone"])
def test_other_words_do_not_fire(listen, words):
    assert listen(spoken(words)) == []


@pytest.mark.parametrize("level", [0.0, 1e-4, 0.01, 0.3])
def test_noise_never_fires(listen, level):
    rng = np.random.default_rng(3)
    assert listen(level * rng.standard_normal(20 * RATE)) == []


def test_tones_and_knocks_never_fire(listen):
    time = np.arange(10 * RATE) / RATE
    beeps = 0.3 * np.sin(2 * np.pi * 880 * time) * (np.mod(time, 1.0) < 0.12)
    knocks = np.zeros(10 * RATE)
    knocks[::12_345] = 0.9
    assert listen(beeps + knocks) == []


def test_a_stop_right_after_a_gap_in_the_stream_is_heard(spotter):
    spotter.reset()
    sound = spoken("stop").astype(np.float32)
    for frame in frames(sound[: RATE // 2]):
        assert spotter(frame) is None
    later = frames(sound[RATE - 1600 :], first_sample=100 * FRAME)
    assert len([s for frame in later if (s := spotter(frame))]) == 1


def test_scores_do_not_depend_on_the_size_of_blocks(spotter):
    sound = spoken("stop").astype(np.float32)
    found = []
    for size in (160, FRAME, 5000):
        spotter.reset()
        for at in range(0, len(sound) - size, size):
            spotter(Frame(frozen_samples(sound[at : at + size]), at, at / RATE))
        found.append([one.score for one in spotter.scores])
    newest = min(map(len, found)) - 10
    reference = found[0][:newest]
    assert len(reference) > 10
    for scores in found[1:]:
        assert scores[:newest] == pytest.approx(reference, abs=1e-4)


def test_an_embedding_comes_with_every_step_from_the_first_on():
    embedder = Embedder()
    assert not list(embedder(np.zeros(STEP - 1, np.float32)))
    (first,) = embedder(np.zeros(1, np.float32))
    assert first == pytest.approx(embedder.quiet, abs=1e-4)


class Scripted:
    """Scores in their order, and quiet embeddings."""

    def __init__(self, scores):
        self.scores = iter(scores)

    def __call__(self, seen):
        assert seen.shape[0] == CONTEXT
        return next(self.scores, -10.0)


def scripted(scores):
    return Spotter(RULE.spotter, Embedder(), Scripted(scores), CONTEXT)


def run(spotter, seconds):
    silence = np.zeros(round(seconds * RATE), np.float32)
    return [s for frame in frames(silence) if (s := spotter(frame))]


def test_what_fired_stays_latched_while_the_score_stays_high():
    (fired,) = run(scripted([-10.0] * 3 + [9.0] * 40), 4.0)
    assert fired.score == pytest.approx(9.0)
    assert fired.time == pytest.approx(100.0 + 5 * STEP / RATE, abs=FRAME / RATE)


def test_two_high_scores_fire_one_does_not_and_after_a_rest_it_fires_again():
    assert run(scripted([-10, 12, -10, 12, -10]), 1.0) == []
    scores = [9.0, 9.0] + [-10.0] * 15 + [9.0, 9.0] + [-10.0] * 10
    assert len(run(scripted(scores), 3.0)) == 2


def test_the_best_score_is_that_of_the_time_asked_for():
    spotter = scripted([-10.0, 3.0, 3.0] + [-10.0] * 20)
    run(spotter, 1.0)
    assert spotter.best(100.0) == pytest.approx(3.0)
    assert spotter.best(100.6) < 0.0
    assert spotter.best(999.0) == float("-inf")


# --- the rule


@pytest.mark.parametrize(
    ("confidence", "is_ready", "is_last", "spotted", "stops"),
    [
        (0.7, True, False, None, True),  # nobody listens: as if there were no spotter
        (0.7, False, False, None, False),
        (0.95, True, True, -10.0, True),  # sure
        (0.95, True, True, -20.0, True),  # sure, whatever the spotter heard
        (0.95, True, False, -20.0, False),  # sure, but talk may go on
        (0.95, False, True, -20.0, False),  # sure, but the word may go on
        (0.7, True, True, -20.0, False),  # one side alone half believes
        (0.7, True, False, 1.5, True),  # both half believe
        (0.7, False, False, 1.5, False),
        (0.7, False, False, 4.5, True),  # the spotter believes: at once
    ],
)
def test_a_written_stop_needs_certainty_or_agreement(confidence, is_ready, is_last, spotted, stops):
    second = StopFusion(RULE.spotter, FakeSpotting(spotted))
    assert second.confirms(StopEvidence(confidence, is_ready, is_last, spotted), "stop") == stops


@pytest.mark.parametrize(
    ("spotted", "ratio", "stops"),
    [(None, 5.0, False), (3.0, 5.0, False), (5.0, -2.0, True), (5.0, -4.0, False)],
)
def test_the_spotter_overrules_only_near_the_recognisers_own_opinion(spotted, ratio, stops):
    assert StopFusion(RULE.spotter, FakeSpotting(spotted)).overrules(spotted, ratio) == stops


def test_what_is_spotted_must_be_a_halt():
    with pytest.raises(CommandsError, match="allowed: stop"):
        load_voice_config(spotter__phrase="tense")


# --- in the pipeline


def decided(text, spotting, confidence=0.8, scores=None):
    recognizer = FakeRecognizer(scores, confidence)
    return decisions(hear(text, Mode.STANDBY, recognizer, config=RULE, spotting=spotting))


def stops(found):
    return [d for d in found if Halt() in d.actions]


def test_an_unsure_stop_that_the_spotter_did_not_hear_is_refused_with_its_reason():
    (decision,) = decided("stop", FakeSpotting(-9.0), 0.7)
    assert stops([decision]) == []
    assert "spotter" in decision.outcome.rejection.words


@pytest.mark.parametrize("spotting", [FakeSpotting(2.0), FakeSpotting(None), None])
def test_an_unsure_stop_that_the_spotter_heard_too_or_that_none_listens_for_stops(spotting):
    (decision,) = stops(decided("stop", spotting, 0.7))
    assert decision.decided_by == "recognizer"


def test_a_word_near_stop_that_the_spotter_believes_in_stops():
    (decision,) = stops(decided("mumble", FakeSpotting(5.0), scores={"stop": -1.0}))
    assert decision.decided_by == "spotter"


@pytest.mark.parametrize(
    ("text", "spotted", "score"),
    [("mumble", 5.0, -9.0), ("mumble", 0.0, -1.0), ("not stop", 5.0, -1.0)],
)
def test_a_word_less_near_or_denied_or_less_believed_in_does_not(text, spotted, score):
    assert stops(decided(text, FakeSpotting(spotted), scores={"stop": score})) == []


def test_the_spotter_alone_stops_in_quiet_and_says_who_it_was():
    (decision,) = stops(decided("1.0", FakeSpotting(None, at=100.8)))
    assert decision.decided_by == "spotter"
    assert decision.outcome == Match("stop", decision.outcome.wer)
    assert decision.hypothesis == Hypothesis("", 0.0, 0.0)


def test_a_stop_that_was_sent_already_is_reported_and_not_sent_again():
    (decision,) = decided("1.0", FakeSpotting(None, at=100.8, is_sent=True))
    assert decision.outcome.command == "stop"
    assert stops([decision]) == []
    assert Call("stop") in decision.actions


def test_after_a_stop_spotted_in_quiet_the_recogniser_still_hears_the_next():
    found = stops(decided("1.0 stop", FakeSpotting(None, at=100.4)))
    assert [d.decided_by for d in found] == ["spotter", "recognizer"]


def test_both_ways_give_one_decision_for_one_word():
    early = stops(decided("stop", FakeSpotting(9.0, at=100.6), 0.95))
    late = stops(decided("stop", FakeSpotting(9.0, at=100.9), 0.95))
    assert len(early) == len(late) == 1
    assert (early[0].decided_by, late[0].decided_by) == ("spotter", "recognizer")

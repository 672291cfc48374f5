# SPDX-License-Identifier: BSD-3-Clause
"""While recognition hangs, the spotter's half-belief in a "stop" is enough; else it is not."""

from types import SimpleNamespace

import pytest

from voice_assist.config import load_voice_config
from voice_assist.pipeline.hang_detection import HangWatch
from voice_assist.ros.recognition_watch import RecognitionStatus, RecognitionWatch
from voice_assist.spotter.spotter import SpotterScore

CONFIG = load_voice_config()
LIMIT, SPOTTER = CONFIG.recognizer.hung_after, CONFIG.spotter
BEGUN = 100.0  # [s] steady clock
CLOCK = 5000.0  # [s] of the clock of frames, when the steady clock shows zero


class Spotting:
    """What a spotter holds: looks."""

    def __init__(self):
        self.looks = []

    def believe(self, score, time):
        self.looks.append(SpotterScore(CLOCK + time, score, 0))

    def best(self, since):
        return max((k.score for k in self.looks if k.time >= since), default=float("-inf"))


class Watched:
    def __init__(self, spotting):
        self._watch = RecognitionWatch(HangWatch(LIMIT, dict, dict), spotting, SPOTTER)

    def at(self, steady, since=BEGUN):
        return self._watch(since, steady, CLOCK + steady)


@pytest.fixture
def spotting():
    return Spotting()


def begun(spotting):
    """A watch at the beginning of a piece of work, seen a second time at once."""
    watched = Watched(spotting)
    for _ in range(2):
        assert watched.at(BEGUN) == RecognitionStatus("", False)
    return watched


@pytest.fixture
def watched(spotting):
    """At the beginning of a piece of work."""
    return begun(spotting)


def hung(watched):
    """The moment after recognition was found to hang, steady clock [s]."""
    now = BEGUN + 1.01 * LIMIT
    assert watched.at(now).is_news
    return now


@pytest.mark.parametrize("score", [SPOTTER.middle, SPOTTER.alone, 20.0])
def test_a_half_believed_stop_in_a_hang_counts_once(watched, spotting, score):
    now = hung(watched)
    spotting.believe(score, now + 0.1)
    assert watched.at(now + 0.11).spotted == score
    assert watched.at(now + 0.12).spotted is None
    spotting.believe(score, now + 0.2)  # still the same word
    assert watched.at(now + 0.21).spotted is None


def test_said_again_later_it_counts_again(watched, spotting):
    now = hung(watched)
    spotting.believe(SPOTTER.middle, now + 0.1)
    assert watched.at(now + 0.11).spotted is not None
    later = now + 0.2 + SPOTTER.rearm_after
    spotting.believe(SPOTTER.middle, later)
    assert watched.at(later).spotted is not None


def test_a_word_that_ended_after_the_work_began_counts_once_the_hang_is_known(watched, spotting):
    spotting.believe(SPOTTER.middle, BEGUN + LIMIT / 2)
    assert watched.at(BEGUN + LIMIT / 2).spotted is None
    seen = watched.at(BEGUN + 1.01 * LIMIT)
    assert seen.is_news
    assert seen.spotted == SPOTTER.middle


@pytest.mark.parametrize(
    ("score", "since"),
    [(SPOTTER.alone, BEGUN - 0.1), (SPOTTER.middle - 0.01, BEGUN + 1.01 * LIMIT)],
)
def test_what_was_heard_before_the_hang_or_is_half_believed_hardly_counts(
    watched, spotting, score, since
):
    spotting.believe(score, since)
    assert watched.at(hung(watched) + 0.01).spotted is None


@pytest.mark.parametrize("since", [None, BEGUN])
def test_while_recognition_is_well_a_half_believed_stop_is_for_it_to_judge(
    watched, spotting, since
):
    spotting.believe(SPOTTER.alone - 0.01, BEGUN + LIMIT / 2)
    assert watched.at(BEGUN + LIMIT / 2 + 0.01, since) == RecognitionStatus("", False)


@pytest.mark.parametrize("since", [None, BEGUN + 2 * LIMIT])
def test_the_end_of_a_hang_is_news_and_the_half_believed_counts_no_more(watched, spotting, since):
    now = hung(watched)
    spotting.believe(SPOTTER.middle, now + 0.1)
    assert watched.at(now + 0.2, since) == RecognitionStatus("", True)
    assert watched.at(now + 0.21, since) == RecognitionStatus("", False)


@pytest.mark.parametrize("spotting", [None, SimpleNamespace(best=lambda since: None)])
def test_without_a_spotter_that_listens_a_hang_is_reported_and_nothing_is_spotted(spotting):
    watched = begun(spotting)
    assert watched.at(hung(watched) + 0.1).spotted is None

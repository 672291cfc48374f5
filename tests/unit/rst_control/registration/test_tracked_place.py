# SPDX-License-Identifier: BSD-3-Clause
"""What is not believed of a tracked place: old, ahead of time, jumping, far."""

from dataclasses import replace

import numpy as np
import pytest

from rst_control.config import load_motion_config
from rst_control.registration.followed_trocar import TrackedTrocar
from rst_control.registration.tracked_place import Report, SteadyPlace
from rst_control.types import Cause, Reason

CONFIG = load_motion_config().controller.tracking
HOME = np.array([0.4, 0.0, 0.3])
BESIDE = HOME + np.array([0.0, 0.005, 0.0])
PERIOD = 0.02


def reported(place, now, places, pulls=None):
    """The time after reports at 50 Hz to what follows a place."""
    for each, pull in zip(places, pulls or [()] * len(places), strict=True):
        now += PERIOD
        place.update(Report(np.array(each), now, pull, arrived=now))
    return now


def steady(places):
    """A follower of the grasp point after such reports, and the time of the last."""
    place = SteadyPlace(CONFIG.grasp_point, CONFIG.age, HOME)
    return place, reported(place, 5.0, places)


def tracked(places):
    """As much of the trocar."""
    trocar = TrackedTrocar(CONFIG, HOME)
    return trocar, reported(trocar, 5.0, places)


def refused(found, reason, words):
    assert isinstance(found, Cause) and found.reason is reason
    assert words in found.words and "allowed" in found.words


def test_a_steady_place_is_the_mean_of_its_reports():
    noise = np.random.default_rng(1).normal(scale=1e-4, size=(60, 3))
    place, now = steady(HOME + np.array([0.01, 0.0, 0.0]) + noise)
    count = int(CONFIG.grasp_point.steady_time / PERIOD)
    np.testing.assert_allclose(
        place.taken(now).place, HOME + np.array([0.01, 0.0, 0.0]), atol=5e-4 / np.sqrt(count)
    )


def test_nothing_tracked_is_no_place():
    place = SteadyPlace(CONFIG.grasp_point, CONFIG.age, HOME)
    assert place.taken(1.0).reason is Reason.TRACKER_STALE


def test_a_place_of_a_moment_is_not_taken_yet():
    place, now = steady([HOME] * 5)
    refused(place.taken(now), Reason.TRACKER_STALE, "tracked for 0.08 s")


def first_taken(steady_time, age, period):
    """Time from the first report to the one with which the place is taken, and the last refusal."""
    place = SteadyPlace(replace(CONFIG.grasp_point, steady_time=steady_time), age, HOME)
    refusal = None
    for number in range(1000):
        now = 5.0 + number * period
        place.update(Report(HOME, now))
        if isinstance(place.taken(now), Report):
            return now - 5.0, refusal
        refusal = place.taken(now)
    raise AssertionError(refusal)


@pytest.mark.parametrize("period", [0.02, 0.04, 0.07, 0.1])
@pytest.mark.parametrize("age", [0.2, 0.5, 2.0])
@pytest.mark.parametrize("steady_time", [0.05, 0.5, 1.0])
def test_a_place_is_taken_once_it_was_steady_for_as_long_as_the_refusal_names(
    steady_time, age, period
):
    taken, refusal = first_taken(steady_time, age, period)
    assert steady_time - 1e-6 <= taken < steady_time + period
    refused(refusal, Reason.TRACKER_STALE, f"allowed from {steady_time:.2f} s on")


@pytest.mark.parametrize("age", [0.2, 0.5, 2.0])
def test_one_report_is_never_taken(age):
    place = SteadyPlace(CONFIG.grasp_point, age, HOME)
    place.update(Report(HOME, 5.0))
    refused(place.taken(5.0), Reason.TRACKER_STALE, "tracked for 0.00 s")
    place.update(Report(HOME, 5.0 + 2.0 * age))  # nobody knows where it was meanwhile
    refused(place.taken(5.0 + 2.0 * age), Reason.TRACKER_STALE, "tracked for 0.00 s")


def test_a_jump_just_before_the_last_reports_counts():
    """Reports so rare that few of them make up the time: they have to cover all of it."""
    place = SteadyPlace(CONFIG.grasp_point, 0.4, HOME)
    for number, aside in enumerate([0.005, 0.0, 0.0]):
        place.update(Report(HOME + np.array([0.0, aside, 0.0]), 5.0 + 0.3 * number))
    refused(place.taken(5.6), Reason.TRACKER_JUMPED, "went 5.0 mm")
    place.update(Report(HOME, 5.9))
    assert isinstance(place.taken(5.9), Report)


def test_an_old_place_is_refused_with_its_age():
    place, now = steady([HOME] * 60)
    refused(place.taken(now + 0.5), Reason.TRACKER_STALE, "0.50 s old")


def test_a_stamp_ahead_of_time_is_refused():
    place, now = steady([HOME] * 60)
    refused(place.taken(now - 0.3), Reason.TRACKER_STALE, "0.30 s ahead")


def test_a_jump_is_refused_until_the_place_is_steady_again():
    place, now = steady([HOME] * 60 + [BESIDE])
    refused(place.taken(now), Reason.TRACKER_JUMPED, "went 5.0 mm")
    now = reported(place, now, [BESIDE] * 60)
    np.testing.assert_allclose(place.taken(now).place, BESIDE)


@pytest.mark.parametrize("away", [0.2, np.nan, np.inf])
def test_a_far_place_is_refused_and_so_is_none(away):
    place, now = steady([HOME + np.array([away, 0.0, 0.0])] * 60)
    refused(place.taken(now), Reason.TRACKER_TOO_FAR, "mm from that of scene.yaml")


def test_one_report_that_is_no_number_is_a_jump():
    place, now = steady([HOME] * 60 + [HOME * np.nan] + [HOME] * 5)
    refused(place.taken(now), Reason.TRACKER_JUMPED, "went nan mm")


@pytest.mark.parametrize("flips", [[0], [3], [0, 3]])
def test_a_way_of_the_pull_that_flips_is_a_jump(flips):
    place, now = steady([HOME] * 60)
    ways = [(0.0, 0.6, -0.8) if number in flips else (0.0, 0.0, 1.0) for number in range(5)]
    now = reported(place, now, [HOME] * 5, ways)
    refused(place.taken(now), Reason.TRACKER_JUMPED, "way of the pull turned")


def test_a_steady_way_of_the_pull_is_taken():
    place, now = steady([HOME] * 60)
    now = reported(place, now, [HOME] * 60, [(0.0, 0.0, 1.0), (0.02, 0.0, 1.0)] * 30)
    assert place.taken(now).pull == (0.02, 0.0, 1.0)


# The trocar.


def breathing(time):
    return HOME + np.array([0.0025 * (1.0 - np.cos(2.0 * np.pi * 0.25 * time)), 0.0, 0.0])


def test_breathing_is_followed_without_delay():
    """Within 0.1 mm at any time, between two reports and ahead of the newest, too."""
    trocar, now, errors = TrackedTrocar(CONFIG, HOME), 0.0, []
    for _ in range(500):
        now += PERIOD
        trocar.update(Report(breathing(now), now))
        if now > 1.0:
            for ahead in (0.0, 0.01, 0.03):
                shift, _ = trocar.shift(now + ahead)
                errors.append(np.linalg.norm(HOME + shift - breathing(now + ahead)))
    assert trocar.objection(now) is None
    assert max(errors) < 1e-4


def test_what_is_read_while_a_report_is_taken_in_is_the_course_before_it(monkeypatch):
    way = np.array([0.03 * PERIOD, 0.0, 0.0])  # [m] of 30 mm/s
    trocar, now = tracked([HOME + number * way for number in range(10)])
    before, read, smoothed = trocar.shift(now + PERIOD), [], TrackedTrocar._smoothed

    def read_meanwhile(*given):
        read.append(trocar.shift(now + PERIOD))
        return smoothed(*given)

    monkeypatch.setattr(TrackedTrocar, "_smoothed", read_meanwhile)
    trocar.update(Report(HOME + 10 * way, now + PERIOD))
    np.testing.assert_array_equal(read, [before])


def test_nothing_heard_is_an_objection():
    assert TrackedTrocar(CONFIG, HOME).objection(0.0).reason is Reason.TRACKER_STALE


def test_silence_is_an_objection():
    trocar, now = tracked([HOME] * 60)
    assert trocar.objection(now) is None
    refused(trocar.objection(now + 0.3), Reason.TRACKER_STALE, "0.30 s old")


def test_a_jump_is_an_objection_until_reports_have_been_good_for_a_while():
    trocar, now = tracked([HOME] * 60 + [BESIDE])
    refused(trocar.objection(now), Reason.TRACKER_JUMPED, "jumped by 5.0 mm")
    for number in range(15):
        now = reported(trocar, now, [BESIDE])
        if number * PERIOD < CONFIG.age:
            assert trocar.objection(now) is not None
    assert trocar.objection(now) is None
    np.testing.assert_allclose(trocar.shift(now)[0], [0.0, 0.005, 0.0], atol=1e-6)


@pytest.mark.parametrize("away", [0.02, np.nan])
def test_beyond_its_range_is_an_objection(away):
    trocar, now = tracked([HOME] * 60)
    trocar = TrackedTrocar(
        replace(CONFIG, trocar=replace(CONFIG.trocar, jump=0.01, max_speed=0.1)), HOME
    )
    trocar.update(Report(HOME + np.array([away, 0.0, 0.0]), now))
    refused(trocar.objection(now), Reason.TRACKER_TOO_FAR, "mm from that of scene.yaml")


def test_an_older_report_changes_nothing():
    trocar, now = tracked([HOME] * 60)
    trocar.update(Report(HOME + np.array([0.02, 0.0, 0.0]), now - 0.1))
    assert trocar.objection(now) is None


def test_one_report_from_the_future_does_not_shut_out_those_after_it():
    """A tracker's clock that was an hour ahead for one report: the trocar counts again."""
    trocar, now = tracked([HOME] * 60)
    trocar.update(Report(HOME, now + 3600.0, arrived=now))
    refused(trocar.objection(now), Reason.TRACKER_STALE, "3600.00 s ahead")
    now = reported(trocar, now, [HOME] * 15)
    assert trocar.objection(now) is None
    np.testing.assert_allclose(trocar.shift(now)[0], np.zeros(3), atol=1e-9)


def test_a_grasp_point_is_steady_again_after_one_report_from_the_future():
    place, now = steady([HOME] * 60)
    place.update(Report(HOME, now + 3600.0, arrived=now))
    refused(place.taken(now), Reason.TRACKER_STALE, "3600.00 s ahead")
    now = reported(place, now, [HOME] * 60)
    np.testing.assert_allclose(place.taken(now).place, HOME)

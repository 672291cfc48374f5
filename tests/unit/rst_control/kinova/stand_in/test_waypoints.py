# SPDX-License-Identifier: BSD-3-Clause
import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline, PchipInterpolator

from rst_control.config import CONFIG_FOLDER
from rst_control.kinova.stand_in.config import FILE, StandInConfig
from rst_control.kinova.stand_in.waypoints import Course, Waypoint
from typed_config import ConfigError, load_config, load_yaml


def test_the_course_is_the_monotone_cubic_through_the_way_points():
    rng = np.random.default_rng(4)
    waypoints = [Waypoint(tuple(rng.normal(size=7)), d) for d in rng.uniform(0.1, 1.0, 5)]
    course = Course(np.zeros(7), waypoints)
    times = np.concatenate([[0.0], np.cumsum([w.duration for w in waypoints])])
    knots = np.vstack([np.zeros(7), [w.angles for w in waypoints]])
    slopes = PchipInterpolator(times, knots)(times, 1)
    slopes[[0, -1]] = 0.0  # at rest at both ends
    wanted = CubicHermiteSpline(times, knots, slopes)
    for time in np.linspace(0.0, 0.999 * course.duration, 50):
        position, velocity = course.at(time)
        np.testing.assert_allclose(position, wanted(time), atol=1e-12)
        np.testing.assert_allclose(velocity, wanted(time, 1), atol=1e-11)


@pytest.mark.parametrize("name", ["first_duration", "min_duration"])
def test_no_way_point_may_take_no_time(name):
    settings = load_yaml(CONFIG_FOLDER / FILE)
    driver = {**settings["driver"], name: 0.0}
    with pytest.raises(ConfigError, match=rf"driver\.{name}.*0\.0001"):
        load_config(StandInConfig, {**settings, "driver": driver})

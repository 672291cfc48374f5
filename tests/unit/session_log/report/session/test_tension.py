# SPDX-License-Identifier: BSD-3-Clause
"""What tension a session holds: as it was measured, never the zeros of a robot without a sensor."""

import math

import numpy as np
import pytest

from session_log.mcap_file.condition import FileCondition
from session_log.mcap_file.summary import RecordingSummary
from session_log.report.session.session_data import SILENT, SessionData
from session_log.report.session.shaft import rcm_from_joints
from session_log.report.session.summary import summarise
from session_log.report.session.tension import (
    measured_tension,
    tension_settings,
    tension_with_target,
)
from session_log.types import TopicCount

TOPIC = "/robot/tension"
BRIDGE = {"kinova_bridge": "tension: {source: topic, age: 0.1}"}


def settings(source):
    return {"rst_controller": f"controller: {{tension: {{source: {source}, limit: 2.4}}}}"}


def session(parameters, topics=(), tension=(1.5,), target=0.0):
    """What a controller reports of the tension, with these settings and recorded topics."""
    condition = FileCondition(metadata=[("parameters", parameters)])
    counts = {topic: TopicCount("geometry_msgs/WrenchStamped", 1) for topic in topics}
    data = SessionData(RecordingSummary(condition, counts))
    zeros = np.zeros(len(tension))
    data.controller.extend(np.arange(len(tension)), zeros, np.array(tension), zeros + target, zeros)
    return data


@pytest.mark.parametrize(
    ("parameters", "topics", "expected"),
    [
        ({}, (), []),
        (settings("none"), (), []),
        (settings("none"), (TOPIC,), []),  # its own are zero, and those of the topic no numbers
        (BRIDGE, (), []),
        ({}, (TOPIC,), [1.5]),
        (settings("sensor"), (), [1.5]),
        (BRIDGE | settings("joint_torque"), (), [1.5]),
        ({"odd": "tension: [", **settings("sensor")}, (), [1.5]),
    ],
)
def test_the_controllers_tension_counts_where_something_measures_it(parameters, topics, expected):
    found = measured_tension(session(parameters, topics), TOPIC)
    assert list(found["tension"]) == expected


def test_the_topic_counts_before_the_controller():
    data = session(settings("none"), (TOPIC,))
    data.tension.extend(np.array([0.0]), np.array([1.25]))
    assert list(measured_tension(data, TOPIC)["tension"]) == [1.25]


def test_the_largest_tension_is_also_that_without_a_target(report_config):
    data = session(settings("sensor"), tension=[1.0, math.nan, 2.3, math.inf], target=0.0)
    rcm = rcm_from_joints(data, report_config)
    summary = summarise("s", data, [], rcm, report_config)
    assert summary.tension == 2.3
    assert math.isnan(summary.tension_with_target)
    data = session(settings("none"), tension=[0.0, 0.0])
    assert math.isnan(summarise("s", data, [], rcm, report_config).tension)


@pytest.mark.parametrize(
    ("parameters", "limit"),
    [
        ({"other": "x: [", "controller": "tension: {limit: 2.4, maximum: 2.0}\nx: 1"}, 2.4),
        ({"robot1": "controller: {tension: {limit: 3}}"}, 3.0),
        (BRIDGE, None),
        ({"controller": "watchdogs: {tension: 1}"}, None),
    ],
)
def test_the_settings_of_the_tension_are_those_that_name_a_limit(parameters, limit):
    assert tension_settings(session(parameters)).get("limit") == limit


def sensed(said, target, *pulls):
    """A controller that says this target at these times [s], and pulls of a sensor: [s], [N]."""
    data = session(settings("sensor"), tension=())
    nothing = np.zeros(len(said))
    data.controller.extend(np.array(said), nothing, nothing, nothing + target, nothing)
    data.tension.extend(*np.array(pulls).T)
    return data


def test_a_pull_after_the_controller_died_is_none_with_a_target(report_config):
    pulls = [(time, 8.0 if time == 15.0 else 2.0) for time in np.arange(0.0, 20.0, 0.5)]
    data = sensed(np.arange(0.0, 10.0, 0.01), 2.0, *pulls)
    assert tension_with_target(data).max() == 2.0
    rcm = rcm_from_joints(data, report_config)
    summary = summarise("s", data, [], rcm, report_config)
    assert (summary.tension_with_target, summary.tension) == (2.0, 8.0)


def test_a_target_holds_from_when_it_was_said_until_its_controller_is_silent():
    pulls = [(0.9, 5.0), (1.0, 1.0), (1.0 + SILENT, 2.0), (1.1 + SILENT, 6.0)]
    assert tension_with_target(sensed([1.0], 1.0, *pulls)).tolist() == [1.0, 2.0]
    assert not len(tension_with_target(sensed([1.0], 0.0, *pulls)))

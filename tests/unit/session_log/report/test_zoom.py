# SPDX-License-Identifier: BSD-3-Clause
"""The values of the time axis are JSON, whatever was recorded."""

import json
import math

import numpy as np
import pytest

from session_log.report.figures import SessionMaterial
from session_log.report.session.shaft import rcm_from_joints
from session_log.report.zoom import POINTS, zoom_data
from tests.unit.session_log.report.session.test_tension import session, settings


def tension_of(report_config, values, source="sensor"):
    """What the page gets of a controller's tension."""
    data = session(settings(source), tension=values)
    rcm = rcm_from_joints(data, report_config)
    found = zoom_data(SessionMaterial(data, [], report_config, rcm, ()), [])
    text = json.dumps(found, allow_nan=False)
    return {curve["name"]: curve for curve in json.loads(text)["curves"]}["tension [N]"]


@pytest.mark.parametrize("odd", [math.nan, math.inf, -math.inf])
def test_what_is_no_number_is_a_gap(report_config, odd):
    curve = tension_of(report_config, [1.0, odd, 2.0])
    assert curve["time"] == [0.0, 1.0, 2.0] and curve["value"] == [1.0, None, 2.0]


def test_a_long_curve_keeps_its_gaps_and_its_extremes(report_config):
    values = [1.0] * (2 * POINTS)
    values[5000], values[9000:9050], values[9010] = 3.0, [math.nan] * 50, 0.25
    curve = tension_of(report_config, values)
    known = [v for v in curve["value"] if v is not None]
    assert max(known) == 3.0 and min(known) == 0.25 and None in curve["value"]


@pytest.mark.parametrize(("values", "source"), [([0.0], "none"), ([math.nan] * 2, "sensor")])
def test_what_was_not_measured_has_no_curve(report_config, values, source):
    assert tension_of(report_config, values, source)["time"] == []


def test_a_curve_has_a_gap_where_nothing_was_recorded(report_config):
    data = session(settings("sensor"), tension=[1.0] * 5)
    data.tension.extend(np.array([0.0, 0.1, 0.2, 9.0, 9.1]), np.ones(5))
    rcm = rcm_from_joints(data, report_config)
    _, curve = zoom_data(SessionMaterial(data, [], report_config, rcm, ()), [])["curves"]
    assert curve["value"] == [1.0, 1.0, 1.0, None, 1.0, 1.0]

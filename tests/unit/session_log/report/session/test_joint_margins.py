# SPDX-License-Identifier: BSD-3-Clause
"""Margins of joints that turn and of those that slide, where some positions are no numbers."""

import math

import numpy as np
import pytest

from session_log.mcap_file.summary import RecordingSummary
from session_log.report.session.joint_margins import (
    JointMargin,
    joint_limits,
    joint_margins,
    smallest_margin,
    unknown_positions,
)
from session_log.report.session.session_data import SampledTable, SessionData


def urdf(**joints):
    """Text of a model: kind, lower and upper limit by name."""
    parts = (
        f'<joint name="{name}" type="{kind}"><limit lower="{low}" upper="{high}"/></joint>'
        for name, (kind, low, high) in joints.items()
    )
    return f"<robot>{''.join(parts)}</robot>"


MODEL = urdf(turn=("revolute", -1, 1), slide=("prismatic", 0, 0.1), endless=("continuous", 0, 0))


def session(model=MODEL, **positions):
    data = SessionData(RecordingSummary(None), urdf=model)
    data.joints = SampledTable(("time", *positions))
    columns = [np.array(q, dtype=float) for q in positions.values()]
    data.joints.extend(np.arange(len(columns[0])), *columns)
    return data


def test_a_sliding_joint_keeps_its_unit_and_is_not_the_smallest_margin():
    data = session(turn=[0.0, 0.9], slide=[0.05, 0.08], endless=[0.0, 9.0])
    margins = joint_margins(data)
    assert margins["turn"] == JointMargin(pytest.approx(0.1), False)
    assert margins["slide"] == JointMargin(pytest.approx(0.02), True)
    assert margins.keys() == {"turn", "slide"}
    assert smallest_margin(data) == pytest.approx(0.1)


@pytest.mark.parametrize("odd", [math.nan, math.inf, -math.inf])
def test_positions_that_are_no_numbers_are_left_out_and_counted(odd):
    data = session(turn=[0.5, odd, -0.2], slide=[odd] * 3)
    assert joint_margins(data) == {"turn": JointMargin(0.5, False)}
    assert unknown_positions(data) == {"turn": 1, "slide": 3}
    assert smallest_margin(data) == 0.5
    assert unknown_positions(session(turn=[0.0])) == {}


def test_without_joints_or_limits_there_is_no_margin():
    nothing = SessionData(RecordingSummary(None), urdf=MODEL)
    for data in (nothing, session(model="", turn=[0.0]), session(slide=[0.0])):
        assert math.isnan(smallest_margin(data))
    assert unknown_positions(nothing) == {}


@pytest.mark.parametrize("limit", ["nan", "inf", "wide"])
def test_a_limit_that_is_no_number_is_none(limit):
    assert joint_limits(urdf(a=("revolute", -1, limit))) == {}

# SPDX-License-Identifier: BSD-3-Clause
"""The tool is homed only by nobody's tissue, in nobody's patient, and as asked and confirmed."""

from dataclasses import replace

import numpy as np
import pytest

from rst_control.admission.first_motion_gate import VALID_FOR
from rst_control.admission.homing_gate import HomingGate
from rst_control.execution.snapshot import ControllerSnapshot
from rst_control.kinematics.configuration import robot_joints
from rst_control.types import ControllerMode, Measurement, State

STILL = np.zeros(10)


class Table:
    """A robot, and the gate that is asked about it."""

    def __init__(self, config, planner, q):
        self.now, self.config = 10.0, config
        self.gate = HomingGate(config, lambda: planner.patient, lambda: self.now)
        self.mode, self.joints = ControllerMode(), robot_joints(q, 0.0)

    def ask(self, age=0.002, **measured):
        fields = {"velocity": STILL, "effort": STILL, "stamp": self.now - age, **measured}
        measurement = Measurement(position=self.joints, **fields)
        view = replace(ControllerSnapshot.at_start(), mode=self.mode, measurement=measurement)
        return self.gate.refusal(view)


@pytest.fixture
def table(motion_config, planner, gate):
    return Table(motion_config.controller, planner, gate)


def test_outside_at_rest_with_empty_jaws_it_may_be_homed(table):
    assert table.ask() == ""


def test_with_the_tool_in_the_patient_it_is_refused(motion_config, planner, home):
    table = Table(motion_config.controller, planner, home)
    assert "withdraw it first" in table.ask()


def test_what_the_unhomed_wrist_says_of_itself_does_not_count(table, planner, home):
    inside = Table(table.config, planner, np.array([*home[:7], 1.5, 1.5]))
    assert "withdraw it first" in inside.ask()


def test_it_is_refused_while_the_assistance_is_active_moving_or_latched_in_it(table):
    for mode in (
        ControllerMode(State.ACTIVE, is_active=True),
        ControllerMode(State.MOVING, is_active=True),
        ControllerMode(State.HALTED, is_active=True),
        ControllerMode(State.STOPPING),
    ):
        table.mode = mode
        assert "terminate" in table.ask()


def test_it_is_refused_with_tissue_in_motion_and_where_nothing_is_known(table, planner):
    assert "hold tissue" in table.ask(gripped=True)
    assert "not at rest" in table.ask(velocity=np.full(10, 0.1))
    assert "not known" in table.ask(age=0.5)
    assert "not known" in table.ask(connected=False)
    assert "not known" in table.gate.refusal(ControllerSnapshot.at_start())


def test_in_air_the_shaft_may_be_at_the_trocars_point_and_nothing_else(
    motion_config, planner, home
):
    table = Table(replace(motion_config.controller, homing="anywhere"), planner, home)
    assert table.ask() == ""
    assert table.ask(gripped=True)
    table.mode = ControllerMode(State.ACTIVE, is_active=True)
    assert table.ask()


def test_in_a_dry_run_it_is_confirmed_each_time(motion_config, planner, gate):
    table = Table(replace(motion_config.controller, first_motion="confirmed"), planner, gate)
    assert not table.gate.confirm()
    assert "rst_control/confirm" in table.ask()
    assert table.gate.confirm() and not table.gate.confirm()
    assert table.ask() == ""
    assert "rst_control/confirm" in table.ask()
    table.gate.confirm()
    table.now += VALID_FOR + 1.0
    assert "rst_control/confirm" in table.ask()
    assert "hold tissue" in table.ask(gripped=True)
    assert not table.gate.confirm()  # what was refused since is not confirmed


def test_what_was_asked_long_ago_or_before_something_else_was_shown_is_not_confirmed(
    motion_config, planner, gate
):
    table = Table(replace(motion_config.controller, first_motion="confirmed"), planner, gate)
    table.ask()
    table.now += VALID_FOR + 1.0
    assert not table.gate.confirm()
    table.ask()
    table.gate.forget()
    assert not table.gate.confirm()
    assert "rst_control/confirm" in table.ask()


def test_the_room_for_homing_is_that_of_the_jaws_however_far_open(motion_config, planner):
    wrist_to_end, radius = 0.0265 + 0.002, 0.015  # [m] of collision.yaml: both jaws
    expected = wrist_to_end + radius + motion_config.scene.surface_margin
    assert planner.patient.sweep == pytest.approx(expected, abs=1e-6)

# SPDX-License-Identifier: BSD-3-Clause
"""The stand-in for OpenRST's control node: states, homing, no clamp, no watchdog."""

from dataclasses import replace

import numpy as np
import pytest

from rst_control.kinova.stand_in import load_stand_in_config
from rst_control.kinova.stand_in.openrst import OpenRst
from rst_control.kinova.tool import ToolState

CONFIG = load_stand_in_config().tool
START = (0.5, 0.1, 0.1)
HOMING = 60.0  # [s] more than homing takes
HASTY = {"homing_speed": 1.4, "homing_dwell": 0.02}  # where homing is not what is tested


class Rig:
    """The node in simulated time."""

    def __init__(self, **changes):
        self.node = OpenRst(replace(CONFIG, **{**HASTY, **changes}), START)
        self.now, self.gripping = 0.0, False

    def run(self, seconds, until=lambda: False):
        end = self.now + seconds
        positions = []
        while self.now < end - 1e-9 and not until():
            self.now += 0.002
            self.node.step(self.now, self.gripping)
            positions.append(self.node.position.copy())
        return np.array(positions)

    def ask(self, message):
        answers = []
        known = self.node.request(message, answers.append)
        return answers if known else None

    def home(self):
        assert self.ask("connect") == [True]
        answers = self.ask("calibrate")
        self.run(HOMING, until=lambda: answers)
        assert answers == [True]
        assert self.ask("pos_control_on") == [True]
        return self


def test_nothing_moves_and_no_joint_states_come_before_it_is_ready():
    rig = Rig()
    for message in (None, "connect"):
        if message:
            rig.ask(message)
        rig.node.take_command([0.0, 0.0, 0.0])
        rig.run(1.0)
        assert rig.node.reported is None
        assert rig.node.position == pytest.approx(START)


def test_homing_is_answered_at_its_end_and_drives_every_joint_against_both_stops():
    rig = Rig(homing_speed=CONFIG.homing_speed, homing_dwell=CONFIG.homing_dwell)
    rig.ask("connect")
    answers = rig.ask("calibrate")
    assert answers == []
    seen = rig.run(HOMING, until=lambda: answers)
    assert answers == [True]
    assert rig.now > 10.0
    for joint, stop in enumerate(CONFIG.stops):
        assert seen[:, joint].max() == pytest.approx(stop)
        assert seen[:, joint].min() == pytest.approx(-stop)
    assert (seen[:, 1] + seen[:, 2]).min() >= -1e-9  # the jaws never cross
    assert rig.node.position == pytest.approx([0.0, 0.0, 0.0])
    assert rig.node.state is ToolState.READY


def test_homed_it_follows_commands_and_holds_the_last_for_ever():
    rig = Rig().home()
    rig.node.take_command([0.3, -0.2, 0.4])
    rig.run(2.0)
    assert rig.node.reported == pytest.approx([0.3, -0.2, 0.4], abs=1e-6)
    assert not rig.node.is_moving
    rig.run(10.0)
    assert rig.node.reported == pytest.approx([0.3, -0.2, 0.4], abs=1e-6)


def test_homing_keeps_the_last_command_and_position_control_then_goes_there():
    rig = Rig().home()
    rig.node.take_command([0.3, -0.2, 0.4])
    rig.run(2.0)
    rig.home()
    assert rig.node.position == pytest.approx([0.0, 0.0, 0.0])
    rig.run(2.0)
    assert rig.node.reported == pytest.approx([0.3, -0.2, 0.4], abs=1e-6)


def test_a_command_while_it_is_only_connected_counts_once_its_controller_ran():
    rig = Rig()
    rig.ask("connect")
    rig.node.take_command([0.3, -0.2, 0.4])  # its controller starts where the joints are
    rig.home()
    rig.run(2.0)
    assert rig.node.reported == pytest.approx([0.0, 0.0, 0.0])
    rig.ask("connect")
    rig.node.take_command([0.1, 0.0, 0.2])
    rig.home()
    rig.run(2.0)
    assert rig.node.reported == pytest.approx([0.1, 0.0, 0.2], abs=1e-6)


def test_commands_are_not_clamped_the_joint_stops_at_its_stop():
    rig = Rig().home()
    rig.node.take_command([9.0, 0.0, 0.0])
    rig.run(5.0)
    assert rig.node.reported[0] == pytest.approx(CONFIG.stops[0])
    assert not rig.node.is_moving


def test_position_control_is_granted_without_homing_and_then_means_nothing():
    rig = Rig()
    assert rig.ask("connect") == [True]
    assert rig.ask("pos_control_on") == [True]
    assert rig.node.reported == pytest.approx([0.0, 0.0, 0.0])  # wherever the joints are
    rig.node.take_command([0.2, 0.0, 0.0])
    rig.run(5.0)
    assert rig.node.reported == pytest.approx([0.0, 0.0, 0.0])
    assert rig.node.position == pytest.approx([CONFIG.stops[0], *START[1:]])


def test_calibrate_before_connect_is_granted_at_once_and_homes_nothing():
    rig = Rig()
    assert rig.ask("calibrate") == [True]
    assert rig.node.state is ToolState.READY
    assert not rig.node.is_homed


def test_control_off_leaves_it_connected_not_ready():
    rig = Rig().home()
    rig.node.take_command([0.4, 0.0, 0.0])
    rig.run(0.1)
    assert rig.ask("control_off") == [True]
    assert rig.node.state is ToolState.CONNECTED
    here = rig.node.position.copy()
    rig.run(1.0)
    assert rig.node.position == pytest.approx(here)


@pytest.mark.parametrize("message", ["home", "", "Connect", "pos_control_on "])
def test_unknown_requests_fail(message):
    rig = Rig().home()
    assert rig.ask(message) is None
    assert rig.node.state is ToolState.POSITION_CONTROL


@pytest.mark.parametrize("command", [[], [0.1], [0.1] * 4, [float("nan"), 0.0, 0.0]])
def test_commands_that_make_no_sense_change_nothing(command):
    rig = Rig().home()
    rig.node.take_command([0.1, 0.1, 0.1])
    rig.run(1.0)
    rig.node.take_command(command)
    rig.run(1.0)
    assert rig.node.reported == pytest.approx([0.1, 0.1, 0.1], abs=1e-6)


def test_tissue_keeps_the_jaws_open_and_lets_them_open_further():
    rig = Rig().home()
    rig.node.take_command([0.0, 0.2, 0.2])
    rig.run(1.0)
    rig.node.take_command([0.0, 0.0, 0.0])
    rig.gripping = True
    rig.run(1.0)
    assert rig.node.position[1:].sum() == pytest.approx(CONFIG.tissue_opening)
    assert not rig.node.is_moving
    rig.node.take_command([0.0, 0.1, 0.1])
    rig.run(1.0)
    assert rig.node.position[1:].sum() == pytest.approx(0.2, abs=1e-6)


def test_signs_turn_what_the_node_says_into_what_the_jaws_do():
    rig = Rig(signs=(1.0, 1.0, -1.0)).home()
    rig.node.take_command([0.0, 0.2, -0.2])  # jaws of our model open
    rig.gripping = True
    rig.run(1.0)
    assert rig.node.position[1] - rig.node.position[2] == pytest.approx(0.4, abs=1e-6)


def test_it_keeps_its_speed_and_acceleration():
    rig = Rig().home()
    rig.node.take_command([1.4, 0.0, 0.0])
    pitch = rig.run(3.0)[:, 0]
    speed = np.diff(pitch) / 0.002
    assert speed.max() <= CONFIG.speed + 1e-6
    assert (np.diff(speed) / 0.002).max() <= CONFIG.acceleration + 1e-3
    assert pitch.max() < 1.4 + 1e-6

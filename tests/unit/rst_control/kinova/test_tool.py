# SPDX-License-Identifier: BSD-3-Clause
"""OpenRST: nothing before homing, nothing beyond its limits, grip from jaws that stay open."""

from concurrent.futures import Future
from dataclasses import replace

import numpy as np
import pytest

from rst_control.kinova.config import load_kinova_config
from rst_control.kinova.feedback import JointFeedback
from rst_control.kinova.homing import HomingFailed, answered, home
from rst_control.kinova.tool import Grip, Tool, ToolState

NOW = 50.0


def feedback(*joints, stamp=NOW):
    return JointFeedback(np.array(joints), np.zeros(3), np.zeros(3), stamp)


@pytest.fixture
def tool(kinova):
    made = Tool(kinova.bridge.tool, kinova.bridge.grip)
    made.update_state(ToolState.POSITION_CONTROL.value)
    made.is_homed, made.feedback = True, feedback(0.0, 0.3, 0.3)
    return made


def test_a_homed_tool_in_position_control_may_move(tool):
    assert tool.objection(NOW) == ""


@pytest.mark.parametrize(
    ("state", "words"),
    [
        (0, "not homed (it says UNINITIALIZED)"),
        (1, "not homed (it says CONNECTED)"),
        (2, "in READY, needed: POSITION_CONTROL"),
        (4, "in TORQUE_CONTROL, needed: POSITION_CONTROL"),
        (7, "never reported its state"),
    ],
)
def test_any_other_state_is_refused_by_name(tool, state, words):
    tool.update_state(state)
    assert words in tool.objection(NOW)


def test_position_control_without_homing_is_refused(kinova):
    tool = Tool(kinova.bridge.tool, kinova.bridge.grip)
    tool.update_state(ToolState.POSITION_CONTROL.value)
    tool.feedback = feedback(0.0, 0.0, 0.0)
    assert "not homed" in tool.objection(NOW)


def test_homing_is_lost_with_the_connection_and_does_not_come_back_with_the_state(tool):
    tool.update_state(ToolState.CONNECTED.value)
    tool.update_state(ToolState.POSITION_CONTROL.value)
    assert "not homed" in tool.objection(NOW)


@pytest.mark.parametrize("period", [0.008, 0.02])  # [s] between states of the node
def test_speeds_follow_from_positions_for_the_node_reports_none(tool, period):
    for k in range(20):
        tool.take(feedback(0.3 * k * period, 0.2, 0.2 - 0.5 * k * period, stamp=NOW + k * period))
    assert tool.feedback.velocity == pytest.approx([0.3, 0.0, -0.5])
    for k in range(20, 40):
        tool.take(feedback(0.1, 0.2, 0.2, stamp=NOW + k * period))
    assert tool.feedback.velocity == pytest.approx(np.zeros(3))


def test_a_first_state_and_one_of_a_tool_that_homes_have_no_speed(tool):
    tool.take(feedback(0.3, 0.2, 0.2))
    assert tool.feedback.velocity == pytest.approx(np.zeros(3))
    tool.is_homed = False
    tool.take(feedback(0.0, 0.0, 0.0, stamp=NOW + 0.1))  # its encoders were set anew
    assert tool.feedback.velocity == pytest.approx(np.zeros(3))


def test_old_joints_are_refused(tool):
    assert tool.objection(NOW + 0.059) == ""
    assert "61 ms old, allowed 60 ms" in tool.objection(NOW + 0.061)


@pytest.mark.parametrize("joints", [(2.0, 0.3, 0.3), (-9.0, 5.0, -3.0), (0.0, 1.7, 1.7)])
def test_what_is_sent_stays_within_the_limits(tool, kinova, joints):
    sent = tool.command(np.array(joints))
    config = kinova.bridge.tool
    assert (np.array(config.lower) <= sent).all()
    assert (sent <= np.array(config.upper)).all()


def test_signs_turn_the_command(kinova):
    config = replace(kinova.bridge.tool, signs=(-1.0, 1.0, -1.0))
    tool = Tool(config, kinova.bridge.grip)
    np.testing.assert_allclose(tool.command(np.array([0.2, 0.3, 0.1])), [-0.2, 0.3, -0.1])


def test_jaws_kept_open_are_not_driven_ever_harder(tool, kinova):
    tool.feedback = feedback(0.0, 0.2, 0.2)  # 0.4 rad of tissue between them
    sent = tool.command(np.array([0.0, 0.0, 0.0]))
    assert sent[1] + sent[2] == pytest.approx(0.4 - kinova.bridge.grip.over_close)
    assert sent[1] - sent[2] == pytest.approx(0.0)
    opening = tool.command(np.array([0.0, 0.5, 0.5]))
    np.testing.assert_allclose(opening, [0.0, 0.5, 0.5])


def test_a_wrist_off_its_course_for_a_while_is_a_fault_and_open_jaws_are_not(tool):
    course = np.array([0.5, 0.0, 0.0])
    tool.feedback = feedback(0.5, 0.3, 0.3)
    assert tool.following(course, NOW) == ""
    assert tool.following(course, NOW + 5.0) == ""
    tool.feedback = feedback(0.3, 0.0, 0.0)
    assert tool.following(course, NOW + 6.0) == ""
    words = tool.following(course, NOW + 6.6)
    assert "pitch of OpenRST -0.200 rad off" in words
    assert "allowed 0.150" in words


def test_the_yaw_is_checked_too(tool):
    tool.feedback = feedback(0.0, 0.3, -0.3)
    tool.following(np.zeros(3), NOW)
    assert "yaw of OpenRST +0.300" in tool.following(np.zeros(3), NOW + 1.0)


class TestGrip:
    @pytest.fixture
    def grip(self, kinova):
        return Grip(kinova.bridge.grip)

    def test_jaws_that_stay_open_hold_tissue_once_they_have_for_a_while(self, grip):
        assert not grip.update(0.0, 0.04, NOW)
        assert not grip.update(0.0, 0.04, NOW + 0.09)
        assert grip.update(0.0, 0.04, NOW + 0.11)

    def test_closing_jaws_hold_nothing_on_their_way(self, grip):
        for k in range(100):
            commanded = max(0.0, 0.6 - 0.01 * k)
            assert not grip.update(commanded, commanded + 0.05 * (commanded > 0), NOW + 0.01 * k)

    def test_a_short_lag_at_the_end_is_no_tissue(self, grip):
        grip.update(0.0, 0.05, NOW)
        assert not grip.update(0.0, 0.001, NOW + 0.05)
        assert not grip.update(0.0, 0.05, NOW + 0.12)

    def test_what_slips_is_lost_and_what_is_opened_too(self, grip):
        for k in range(3):
            grip.update(0.0, 0.04, NOW + 0.1 * k)
        assert grip.is_gripped
        grip.update(0.0, 0.0, NOW + 1.0)
        assert not grip.update(0.0, 0.0, NOW + 1.06)
        for k in range(3):
            grip.update(0.0, 0.04, NOW + 2.0 + 0.1 * k)
        grip.update(0.5, 0.5, NOW + 3.0)
        assert not grip.update(0.5, 0.5, NOW + 3.06)


class FakeNode:
    """Grants what it is asked for, but for what is named; ready, it reports these joints [rad]."""

    def __init__(self, refuses="", stays="", joints=(0.0, 0.0, 0.0), signs=(1.0, 1.0, 1.0)):
        bridge = load_kinova_config().bridge
        self.tool = Tool(replace(bridge.tool, signs=signs), bridge.grip)
        self.tool.take(feedback(0.7, 0.2, 0.3))  # as before
        self.asked, self.sent, self.joints = [], [], joints
        self.refuses, self.stays = refuses, stays

    def request(self, name):
        self.asked.append(name)
        leads = {
            "connect": ToolState.CONNECTED,
            "calibrate": ToolState.READY,
            "pos_control_on": ToolState.POSITION_CONTROL,
        }
        if name != self.stays:
            self.tool.update_state(leads[name].value)
        if self.tool.state is ToolState.READY and self.joints is not None:
            self.tool.take(feedback(*self.joints))
        return name != self.refuses

    def home(self):
        send = lambda joints: self.sent.append((self.asked[-1], joints.tolist()))  # noqa: E731
        return home(self.request, self.tool, send, lambda condition, limit: condition())


def test_homing_asks_in_order():
    node = FakeNode()
    assert "homed" in node.home()
    assert node.asked == ["connect", "calibrate", "pos_control_on"]


def test_once_it_is_ready_it_is_sent_where_it_reports_to_be_and_only_then_controlled():
    node = FakeNode(joints=(0.02, -0.01, 0.03), signs=(-1.0, 1.0, -1.0))
    node.home()
    assert node.sent == [("calibrate", pytest.approx([-0.02, -0.01, -0.03]))]
    assert node.asked[-1] == "pos_control_on"


def test_a_tool_that_reports_no_joints_once_it_is_ready_is_not_controlled():
    node = FakeNode(joints=None)
    with pytest.raises(HomingFailed, match='"calibrate" left it in READY without joints'):
        node.home()
    assert node.asked == ["connect", "calibrate"] and node.sent == []


@pytest.mark.parametrize("name", ["connect", "calibrate", "pos_control_on"])
def test_what_is_refused_ends_the_homing(name):
    node = FakeNode(refuses=name)
    with pytest.raises(HomingFailed, match=f'"{name}" was refused'):
        node.home()
    assert node.asked[-1] == name


def test_a_request_that_is_granted_without_effect_ends_the_homing():
    with pytest.raises(HomingFailed, match="left it in CONNECTED, needed: READY"):
        FakeNode(stays="calibrate").home()


def test_a_request_without_an_answer_ends_the_homing_and_says_what_still_moves():
    answer = Future()
    with pytest.raises(HomingFailed, match=r'"calibrate" was not answered within 0[.]01 s.*driven'):
        answered(answer, "calibrate", 0.01)
    answer.set_result(True)
    assert answered(answer, "calibrate", 0.01)

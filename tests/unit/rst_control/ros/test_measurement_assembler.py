# SPDX-License-Identifier: BSD-3-Clause
"""What the controller believes of the robot's messages: their order, age, names and clocks."""

import struct
from dataclasses import dataclass, replace

import numpy as np
import pytest

from rst_control.config import load_motion_config
from rst_control.ros.common.serialization import write_joint_state
from rst_control.ros.controller.measurement_assembler import MeasurementAssembler
from rst_control.types import JOINTS

WATCHDOGS = load_motion_config().controller.watchdogs
NOON = 1_700_000_000.0  # [s] wall clock
PERIOD = 0.002


@dataclass
class Message:
    raw: bytes
    arrived: float
    ahead: float = NOON


class Link:
    """An assembler on a steady clock of its own."""

    def __init__(self):
        self.now, self.ahead = 50.0, NOON
        self.assembler = MeasurementAssembler(WATCHDOGS, lambda: self.now)
        self.assembler.gripped = False

    def joints(self, stamp, names=JOINTS, position=None, velocity=None):
        seconds, rest = divmod(stamp, 1.0)
        position = np.zeros(len(names)) if position is None else position
        velocity = np.zeros(len(names)) if velocity is None else velocity
        head = (1, int(seconds), round(rest * 1e9))
        raw = write_joint_state(head, names, position, velocity)
        self.assembler.joints = Message(raw, self.now, self.ahead)

    def tension(self, force=0.0):
        raw = struct.pack("<4I", 1, 2, 3, 0) + struct.pack("<6d", force, 0, 0, 0, 0, 0)
        self.assembler.wrench = Message(raw, self.now)

    def run(self, seconds, stamp=lambda now: NOON + now, tension=0.0, **more):
        """Messages for a while; returns the last measurement."""
        for _ in range(round(seconds / PERIOD)):
            self.now += PERIOD
            if tension is not None:
                self.tension(tension)
            self.joints(stamp(self.now), **more)
            measured = self.assembler.measured()
        return measured

    def age(self):
        return self.now - self.assembler.measured().stamp


@pytest.fixture
def link():
    return Link()


def test_until_the_robot_has_reported_its_grip_nothing_is_measured(link):
    """Jaws that hold tissue would be sent to where it keeps them open, and so let it go."""
    link.assembler.gripped = None
    assert link.run(0.1) is None
    assert "whether its jaws hold anything" in link.assembler.objection
    link.assembler.gripped = True
    assert link.run(0.01).gripped and link.assembler.objection == ""


def rest_at(position, now=1.0):
    raw = write_joint_state((1, 2, 3), JOINTS, position, np.zeros(len(position)))
    return Message(raw, now)


def test_where_the_robot_holds_its_joints_is_passed_on_until_the_robot_is_lost(link):
    assert link.run(0.01).sent_to is None
    link.assembler.rest = rest_at(np.full(10, 0.25))
    for _ in range(2):
        np.testing.assert_array_equal(link.run(0.01).sent_to, np.full(10, 0.25))
    link.now += 0.3
    assert not link.assembler.measured().connected
    assert link.run(0.01).sent_to is None
    link.assembler.rest = rest_at(np.full(10, 0.5))
    assert link.run(0.01).sent_to[0] == 0.5


def test_where_the_robot_held_before_it_was_led_is_not_believed_afterwards(link):
    link.assembler.rest = rest_at(np.full(10, 0.25))
    assert link.run(0.01).sent_to is not None
    link.assembler.led()
    assert link.run(0.01).sent_to is None
    link.assembler.rest = rest_at(np.full(10, 0.26))  # it was still on its way
    link.assembler.led()
    assert link.run(0.01).sent_to is None
    link.assembler.rest = rest_at(np.full(10, 0.3))
    assert link.run(0.01).sent_to[0] == 0.3


@pytest.mark.parametrize("position", [np.full(9, 0.1), np.full(10, np.nan)])
def test_where_the_robot_holds_is_named_where_it_cannot_be_read(link, position):
    link.assembler.rest = rest_at(np.full(10, 0.25))
    link.run(0.01)
    link.assembler.rest = rest_at(position)
    measured = link.run(PERIOD)
    assert measured.sent_to is None
    assert measured.fault.startswith("joint_messages: where the robot holds: ")


def test_what_arrives_is_measured_with_both_clocks(link):
    measured = link.run(0.1, tension=0.5)
    assert (measured.connected, measured.fault, measured.tension) == (True, "", 0.5)
    assert measured.stamp == link.now
    assert measured.sent == pytest.approx(link.now, abs=1e-6)


def test_one_message_overtaken_by_another_is_refused_and_counted_and_no_fault(link):
    link.run(0.1)
    measured = link.run(PERIOD, stamp=lambda now: NOON + now - 0.01)
    assert measured.fault == "" and measured.connected
    assert link.age() == pytest.approx(PERIOD)
    assert "1 refused so far, out of order" in link.assembler.objection
    assert link.run(PERIOD).fault == ""
    assert link.age() == 0.0


@pytest.mark.parametrize(
    "stamp",
    [lambda now: NOON + 50.1, lambda now: NOON + 10.0, lambda now: NOON + 50.1 - 1e-3 * now],
    ids=["the same", "long ago", "going back"],
)
def test_stamps_that_do_not_advance_leave_the_states_to_grow_stale_and_say_why(link, stamp):
    link.run(0.1)
    measured = link.run(0.03, stamp=stamp)
    assert link.age() == pytest.approx(0.03)
    assert "refused: joint states out of order" in measured.fault and measured.connected


def test_a_stamp_from_the_future_keeps_nothing_fresh(link):
    link.run(0.1)
    link.run(PERIOD, stamp=lambda now: NOON + now + 3600.0)
    for _ in range(20):
        link.now += PERIOD
        link.assembler.measured()
    assert link.age() == pytest.approx(0.04)
    link.run(0.02)  # stamped right again: before the last, so refused
    assert link.age() == pytest.approx(0.06)


@pytest.mark.parametrize("jump", [-5.0, 5.0, -0.004, 3600.0])
def test_a_wall_clock_that_jumps_at_worst_loses_the_robot_for_a_moment(link, jump):
    link.run(0.1)
    link.run(0.5, stamp=lambda now: NOON + now + jump)
    assert link.age() == 0.0
    assert link.assembler.measured().connected and link.assembler.measured().fault == ""


@pytest.mark.parametrize("jump", [-5.0, -0.06, 0.06, 5.0])
def test_of_a_clock_that_is_set_on_both_hosts_nothing_is_noticed(link, jump):
    before = link.run(0.1)
    link.ahead += jump
    seen = [link.run(PERIOD, stamp=lambda now: now + link.ahead) for _ in range(150)]
    assert all(one.connected and one.fault == "" for one in seen)
    assert before.sent is not None and seen[0].sent is None  # it may be of before that
    sent = np.diff([one.sent for one in seen[1:]])
    np.testing.assert_allclose(sent, PERIOD, atol=1e-6)


def test_a_message_that_was_on_its_way_as_the_clock_was_set_back_holds_nothing_up(link):
    link.run(0.1)
    link.ahead -= 5.0
    old = link.run(PERIOD, stamp=lambda now: now + link.ahead + 5.0)
    assert old.connected and old.sent is None and link.age() == 0.0
    for _ in range(5):
        assert link.run(PERIOD, stamp=lambda now: now + link.ahead).sent == pytest.approx(link.now)
        assert link.age() == 0.0
    assert link.assembler.out_of_order == 0


def test_while_the_wall_clock_is_back_the_robot_counts_as_lost_before_it_is_believed(link):
    link.run(0.1)
    seen = [link.run(PERIOD, stamp=lambda now: NOON + now - 5.0).connected for _ in range(150)]
    assert seen.index(False) == pytest.approx(0.25 / PERIOD, abs=2)
    assert seen.count(False) <= 2 and seen[-1]


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"names": JOINTS[:-1]}, "without joint_finger_right"),
        ({"names": ("elbow", *JOINTS[1:])}, "without joint_1"),
        ({"position": np.full(10, np.nan)}, "not a number"),
        ({"velocity": np.append(np.zeros(9), np.inf)}, "not a number"),
    ],
)
def test_joint_states_that_cannot_be_used_are_a_fault_at_once(link, more, words):
    before = link.run(0.1)
    measured = link.run(PERIOD, **more)
    assert words in measured.fault
    np.testing.assert_array_equal(measured.position, before.position)
    assert link.run(PERIOD).fault == ""


def test_a_tension_that_is_no_number_is_a_fault_at_once(link):
    link.run(0.1, tension=0.7)
    measured = link.run(PERIOD, tension=float("nan"))
    assert "tension is not a number" in measured.fault
    assert measured.tension == 0.7


def test_a_tension_that_stops_coming_is_a_fault_in_a_while_and_not_before(link):
    link.run(0.1, tension=0.7)
    allowed = WATCHDOGS.sensors.tension_age
    assert link.run(allowed - PERIOD, tension=None).fault == ""
    assert "tension is not measured" in link.run(3 * PERIOD, tension=None).fault


def test_a_grip_and_a_fault_of_the_robot_are_known_with_the_next_measurement(link):
    link.run(0.1)
    link.assembler.fault, link.assembler.gripped = "brakes on", True
    link.now += PERIOD
    assert link.assembler.measured().fault == "brakes on"
    assert link.run(PERIOD).gripped


@pytest.mark.parametrize(("age", "lost_after"), [(0.02, 0.25), (0.5, 0.5)])
def test_a_robot_is_connected_as_long_as_its_joint_states_are_young_enough(age, lost_after):
    link = Link()
    link.assembler = MeasurementAssembler(replace(WATCHDOGS, joint_state_age=age), lambda: link.now)
    link.assembler.gripped = False
    link.run(1.0)
    link.now += lost_after - 0.01
    assert link.assembler.measured().connected
    link.now += 0.02
    assert not link.assembler.measured().connected

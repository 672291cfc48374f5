#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The robot as the controller sees it: set-points in, states out, holding by itself.

It asks for nothing but `robot/servo_jp`, `robot/hold`, `robot/clear_fault`, `joint_states` and
`robot/fault`, so whatever stands between the controller and a robot has to pass it, too.
"""

import threading
import time
import unittest

import numpy as np
import rospy
from sensor_msgs.msg import JointState
from std_msgs.msg import Empty, String

from support.waiting import wait_until
from tests.support.robot_client import run_tests

NAMES = [
    *(f"joint_{i}" for i in range(1, 8)),
    "joint_pitch",
    "joint_finger_left",
    "joint_finger_right",
]
TURN = 0.02  # [rad] of joint_7 in one move
TIME = 3.0  # [s] that it takes
RATE = 500  # [Hz] of set-points
STILL = 1e-4  # [rad] that joints at rest change by, at most


class Stream(threading.Thread):
    """Sends a move of joint_7 as set-points until it is ended or `share` of it is sent."""

    def __init__(self, publisher, start, share=1.0, names=NAMES) -> None:
        super().__init__(daemon=True)
        self._publisher, self._start, self._share, self._names = publisher, start, share, names
        self.ended = False

    def run(self) -> None:
        order = [NAMES.index(name) for name in self._names]
        rate = rospy.Rate(RATE)
        for k in range(int(self._share * TIME * RATE)):
            if self.ended:
                return
            u = np.pi * k / (TIME * RATE)
            position, velocity = np.array(self._start), np.zeros(10)
            position[6] += 0.5 * TURN * (1.0 - np.cos(u))
            velocity[6] = 0.5 * TURN * np.pi / TIME * np.sin(u)
            message = JointState(name=list(self._names))
            message.position, message.velocity = position[order], velocity[order]
            message.header.stamp = rospy.Time.now()
            self._publisher.publish(message)
            rate.sleep()


class ControllerSide(unittest.TestCase):
    """A robot that takes set-points."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.states, cls.faults = [], []
        cls.subscribers = [
            rospy.Subscriber("joint_states", JointState, cls.states.append, tcp_nodelay=True),
            rospy.Subscriber("robot/fault", String, lambda m: cls.faults.append(m.data)),
        ]
        cls.servo = rospy.Publisher("robot/servo_jp", JointState, queue_size=100, tcp_nodelay=True)
        cls.empty = {
            name: rospy.Publisher(f"robot/{name}", Empty, queue_size=1)
            for name in ("hold", "clear_fault")
        }
        wait_until(lambda: len(cls.states) > 10 and cls.faults, "no robot")
        for publisher in (cls.servo, *cls.empty.values()):
            wait_until(publisher.get_num_connections, "nobody listens")

    def setUp(self) -> None:
        self.heal()
        self.start = self.rest()

    @property
    def q(self) -> np.ndarray:
        return np.array(self.states[-1].position)

    def rest(self) -> np.ndarray:
        """Wait until the joints stand; returns where [rad]."""
        time.sleep(0.3)

        def stand() -> bool:
            recent = np.array([s.position for s in self.states[-100:]])
            return bool(np.ptp(recent, axis=0).max() < STILL)

        wait_until(stand, "the joints do not come to rest")
        return self.q

    def heal(self) -> None:
        def is_healthy() -> bool:
            if self.faults[-1]:
                self.empty["clear_fault"].publish(Empty())
                time.sleep(0.2)
            return not self.faults[-1]

        wait_until(is_healthy, "the fault cannot be cleared")

    def stream(self, **options) -> Stream:
        stream = Stream(self.servo, self.start, **options)
        stream.start()
        return stream

    def wait_for_motion(self) -> None:
        wait_until(lambda: abs(self.q[6] - self.start[6]) > 0.15 * TURN or self.faults[-1])

    def test_when_set_points_stop_in_motion_it_holds_and_says_so(self) -> None:
        self.stream(share=0.5).join()
        wait_until(lambda: self.faults[-1], "no fault")
        there = self.rest()
        self.assertGreater(abs(there[6] - self.start[6]), 1e-3)
        time.sleep(1.0)
        self.assertLess(np.abs(self.q - there).max(), STILL)

    def test_hold_stops_it_and_set_points_sent_before_no_longer_count(self) -> None:
        stream = self.stream()
        self.wait_for_motion()
        self.empty["hold"].publish(Empty())
        stream.ended = True
        stream.join()
        there = self.rest()
        self.assertLess(there[6] - self.start[6], 0.95 * TURN)
        time.sleep(0.5)
        self.assertLess(np.abs(self.q - there).max(), STILL)

    def test_names_in_another_order_mean_the_same_joints(self) -> None:
        self.stream(names=NAMES[::-1]).join()
        there = self.rest()
        self.assertLess(np.abs(np.delete(there - self.start, 6)).max(), STILL)
        if not self.faults[-1]:  # a loaded machine may have held up this stream
            self.assertAlmostEqual(there[6] - self.start[6], TURN, delta=2e-4)

    def test_set_points_without_all_joints_are_a_fault_and_move_nothing(self) -> None:
        self.refuse(NAMES[:-1], [*self.start[:-1]])

    def test_unknown_joints_instead_of_ours_are_a_fault_and_move_nothing(self) -> None:
        self.refuse([f"panda_{name}" for name in NAMES], self.start)

    def test_set_points_that_are_no_numbers_are_a_fault_and_move_nothing(self) -> None:
        for broken in (float("nan"), float("inf")):
            with self.subTest(broken):
                self.refuse(NAMES, [broken, *self.start[1:]])
                self.heal()

    def test_a_set_point_far_away_is_a_fault_and_moves_nothing(self) -> None:
        self.refuse(NAMES, self.start + 0.3)

    def refuse(self, names, position) -> None:
        message = JointState(name=list(names), position=list(position))
        message.velocity = [0.0] * len(names)

        def is_refused() -> str:  # said again: one that is delivered late does not count
            message.header.stamp = rospy.Time.now()
            self.servo.publish(message)
            return self.faults[-1]

        wait_until(is_refused, "no fault", every=0.2)
        self.assertLess(np.abs(self.rest() - self.start).max(), STILL)


if __name__ == "__main__":
    run_tests(ControllerSide, "driver_contract_fast")

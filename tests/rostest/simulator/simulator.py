#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The simulated robot by ROS alone: what it publishes and serves.

What it makes of set-points: driver_contract_fast.py.
"""

import time
import unittest

import numpy as np
import rospy
from diagnostic_msgs.msg import DiagnosticArray
from driver_contract_fast import NAMES
from geometry_msgs.msg import WrenchStamped
from sensor_msgs.msg import CompressedImage, JointState
from std_msgs.msg import Bool, String
from std_srvs.srv import Trigger

from support.waiting import PATIENCE, wait_until
from tests.support.robot_client import run_tests


class Simulator(unittest.TestCase):
    """A robot that nobody controls."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.states, cls.faults, cls.pictures = [], [], []
        cls.subscribers = [
            rospy.Subscriber("joint_states", JointState, cls.states.append),
            rospy.Subscriber("robot/fault", String, lambda m: cls.faults.append(m.data)),
            rospy.Subscriber("robot/scene/compressed", CompressedImage, cls.pictures.append),
        ]
        wait_until(lambda: len(cls.states) > 100 and cls.faults)

    def test_joint_states_are_complete_and_in_order(self) -> None:
        message = self.states[-1]
        self.assertEqual(list(message.name), NAMES)
        self.assertEqual(message.header.frame_id, "base_link")
        self.assertTrue(len(message.position) == len(message.velocity) == len(message.effort) == 10)
        stamps = [s.header.stamp.to_sec() for s in self.states[-100:]]
        self.assertTrue(np.allclose(np.diff(stamps), 0.002, atol=1e-6) or min(np.diff(stamps)) > 0)
        self.assertLess(abs(stamps[-1] - time.time()), 5.0)

    def test_tension_and_grip_are_reported_from_the_start(self) -> None:
        wrench = rospy.wait_for_message("robot/tension", WrenchStamped, PATIENCE)
        self.assertEqual(wrench.header.frame_id, "base_link")
        self.assertEqual((wrench.wrench.force.x, wrench.wrench.force.z), (0.0, 0.0))
        self.assertFalse(rospy.wait_for_message("robot/gripped", Bool, PATIENCE).data)

    def test_snapshot_publishes_a_picture(self) -> None:
        count = len(self.pictures)
        rospy.wait_for_service("robot/snapshot", PATIENCE)
        ask = rospy.ServiceProxy("robot/snapshot", Trigger)
        wait_until(lambda: ask().success, "a picture")  # drawn with what others leave of the cores
        wait_until(lambda: len(self.pictures) > count)
        self.assertEqual(self.pictures[-1].format, "png")
        self.assertTrue(bytes(self.pictures[-1].data).startswith(b"\x89PNG"))

    def test_tissue_can_be_reset(self) -> None:
        reply = rospy.ServiceProxy("robot/reset_tissue", Trigger)()
        self.assertTrue(reply.success, reply.message)

    def test_diagnostics_report_how_the_simulation_fares(self) -> None:
        keys: set[str] = set()  # of all nodes; the recorder reports there, too

        def note(message: DiagnosticArray) -> None:
            keys.update(value.key for status in message.status for value in status.values)

        rospy.Subscriber("/diagnostics", DiagnosticArray, note)
        wait_until(lambda: keys >= {"real-time factor", "late steps", "servo"}, "its diagnostics")


if __name__ == "__main__":
    run_tests(Simulator, "simulator_test")

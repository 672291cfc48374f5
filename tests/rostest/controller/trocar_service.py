#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The trocar set by service while the system runs, and the motion that then goes through it."""

import numpy as np
import rospy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Point, PointStamped

from rst_control.kinematics.configuration import Configuration, planning_joints
from rst_control.kinematics.rcm import rcm_error_vector
from rst_control.kinematics.robot_model import load_robot
from rst_control.srv import SetTrocar
from tests.support.robot_client import RobotTest, run_tests

ASIDE = 4e-4  # [m] of the new trocar from the shaft
SEATED = 50e-6  # [m] that the shaft may be off a trocar it goes through


class TrocarService(RobotTest):
    """The tests run in the order of their names and build on one robot."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.heard = []
        cls.diagnosed = ""
        cls.topics = [
            rospy.Subscriber("rst_control/trocar", PointStamped, cls.heard.append),
            rospy.Subscriber("/diagnostics", DiagnosticArray, cls.note),
        ]
        rospy.wait_for_service("rst_control/set_trocar", 60.0)
        cls.service = rospy.ServiceProxy("rst_control/set_trocar", SetTrocar)
        cls.robot.wait(lambda: cls.heard)
        cls.first = cls.published()

    @classmethod
    def tearDownClass(cls):
        cls.robot.start_fresh()
        assert cls.service(Point(*cls.first)).accepted
        super().tearDownClass()

    @classmethod
    def note(cls, message):
        """Keep what the controller's diagnostics say of the trocar."""
        values = [v.value for s in message.status for v in s.values if v.key == "trocar"]
        cls.diagnosed = values[0] if values else cls.diagnosed

    @classmethod
    def published(cls):
        p = cls.heard[-1].point
        return np.array([p.x, p.y, p.z])

    def shaft(self):
        q, _ = planning_joints(np.array(self.robot.joints.position))
        return Configuration(load_robot(), q).T_base_shaft

    def off(self, trocar):
        T = self.shaft()
        return np.linalg.norm(rcm_error_vector(T[:3, 3], T[:3, 2], trocar))

    def is_logged(self, kind, message):
        """Whether the newest such event holds the message."""
        entries = [event.message for event in self.robot.events if event.kind == kind]
        return bool(entries) and message in entries[-1]

    def refused(self, trocar):
        count = len(self.heard)
        reply = self.service(Point(*trocar))
        self.assertFalse(reply.accepted, reply.message)
        self.robot.wait(lambda: self.is_logged("trocar_refused", reply.message))
        self.assertEqual(len(self.heard), count)
        return reply.message

    def set(self, trocar):
        count = len(self.heard)
        reply = self.service(Point(*trocar))
        self.assertTrue(reply.accepted, reply.message)
        self.robot.wait(lambda: len(self.heard) > count)
        np.testing.assert_array_equal(self.published(), trocar)
        self.robot.wait(lambda: self.is_logged("trocar_set", reply.message))
        return reply.message

    def test_1_the_trocar_of_the_settings_is_published_and_in_diagnostics(self):
        np.testing.assert_array_equal(self.first, [0.406, -0.024, 0.415])
        self.robot.wait(lambda: "(0.406000, -0.024000, 0.415000) m" in self.diagnosed)

    def test_2_bad_points_are_refused_with_the_value_and_what_was_allowed(self):
        T = self.shaft()
        self.assertIn("nan m from base_link", self.refused([np.nan, 0.0, 0.4]))
        self.assertIn("allowed 0 to 1.601 m", self.refused([0.0, 0.0, 5.0]))
        words = self.refused(self.first + 5e-3 * T[:3, 0])
        self.assertIn("shaft 5.000 mm off it, allowed 1.000 mm", words)
        words = self.refused(self.first + 0.09 * T[:3, 2])
        self.assertIn("shaft inserted, allowed 50.0 to 250.0 mm", words)

    def test_3_at_rest_in_standby_a_point_near_the_shaft_is_accepted(self):
        type(self).new = self.first + ASIDE * self.shaft()[:3, 0]
        self.assertEqual(self.robot.state.state, "standby")
        self.assertIn("shaft 0.400 mm off it, allowed 1.000 mm", self.set(self.new))
        self.robot.wait(lambda: abs(self.robot.state.rcm_error - ASIDE) < SEATED)
        self.robot.wait(lambda: f"({self.new[0]:.6f}, " in self.diagnosed)

    def test_4_while_moving_it_is_refused(self):
        self.robot.start_fresh()
        self.robot.say("tense")
        self.robot.wait(lambda: self.robot.state.state == "moving")
        self.assertEqual(self.refused(self.new), "moving; wait until the robot is at rest")
        self.robot.wait_for_state("active", limit=60.0)
        self.robot.wait_for_rest()

    def test_5_the_motion_went_through_the_new_trocar(self):
        self.robot.wait(lambda: self.robot.state.tissue_held)
        self.assertLess(self.off(self.new), SEATED)
        self.assertGreater(self.off(self.first), 0.5 * ASIDE)
        self.assertLess(self.robot.state.rcm_error, SEATED)
        pulling = [s.rcm_error for s in self.robot.states if s.phase == "pull"]
        self.assertTrue(pulling and max(pulling) < SEATED)

    def test_6_while_tissue_is_held_it_is_refused(self):
        self.assertIn("tissue is held", self.refused(self.new))

    def test_7_after_release_it_may_be_set_back(self):
        self.robot.say_and_finish("release")
        self.robot.wait_for_rest()
        here = self.new + ASIDE * self.shaft()[:3, 1]
        self.set(here)
        self.assertEqual(self.robot.state.state, "active")
        self.robot.wait(lambda: self.robot.state.rcm_error > 0.5 * ASIDE)
        self.assertLess(self.robot.drift(0.3), 1e-4)


if __name__ == "__main__":
    run_tests(TrocarService, "trocar_service")

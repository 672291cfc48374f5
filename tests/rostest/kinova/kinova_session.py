#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""A session on the strict simulation: homing, the dry run, all seven commands, stops in motion."""

import os
import signal
import unittest

import numpy as np
import rospy
from diagnostic_msgs.msg import DiagnosticArray
from kortex_driver.msg import BaseCyclic_Feedback, BaseFeedback
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool, Empty, String
from std_srvs.srv import Trigger
from visualization_msgs.msg import MarkerArray

from rst_control.kinematics.configuration import Configuration, planning_joints
from rst_control.kinematics.rcm import rcm_state
from rst_control.kinematics.robot_model import load_robot
from rst_control.kinova.arm_state import BEGINS
from rst_control.types import JOINTS
from support.raw_peer import process_of
from tests.support.robot_client import START_LIMIT, RobotClient, run_tests

TROCAR = np.array([0.406, -0.024, 0.415])
RCM = 1e-3  # [m] the limit; how far the arm lags depends on when the machine lets the bridge run
MODEL = load_robot()


READY, MANUALLY_CONTROLLED = 7, 9  # states of the arm


def report(state):
    """What the arm says of itself after somebody used its web page."""
    base = BaseFeedback(active_state=state, active_state_connection_identifier=8)
    return BaseCyclic_Feedback(base=base)


class KinovaSession(unittest.TestCase):
    """In the order of their names, on one robot."""

    @classmethod
    def setUpClass(cls):
        cls.fault, cls.truth, cls.gripped, cls.preview = None, [], False, None
        cls.arm = {}
        rospy.Subscriber("robot/fault", String, lambda m: setattr(cls, "fault", m.data))
        rospy.Subscriber("simulation/joint_states", JointState, cls.on_truth, tcp_nodelay=True)
        rospy.Subscriber("simulation/gripped", Bool, lambda m: setattr(cls, "gripped", m.data))
        rospy.Subscriber(
            "rst_control/preview", MarkerArray, lambda m: setattr(cls, "preview", m.markers)
        )
        rospy.Subscriber("/diagnostics", DiagnosticArray, cls.on_diagnostics)
        cls.robot = RobotClient()
        cls.confirm = rospy.ServiceProxy("rst_control/confirm", Trigger)
        cls.at_the_arm = rospy.Publisher("simulation/arm_state", BaseCyclic_Feedback, queue_size=1)
        cls.emergency_stop = rospy.Publisher("my_gen3/in/emergency_stop", Empty, queue_size=1)
        cls.home_tool = rospy.ServiceProxy("robot/home_tool", Trigger)

    @classmethod
    def on_truth(cls, message):
        order = [message.name.index(name) for name in JOINTS]
        cls.truth.append((np.array(message.position)[order], np.array(message.velocity)[order]))

    @classmethod
    def on_diagnostics(cls, message):
        for status in message.status:
            if status.name == "robot: kinova bridge":
                cls.arm = {v.key: v.value for v in status.values}

    def on_stop(self, _):
        self.stops += 1

    def worst_rcm_error(self):
        """Since the last call; the newest state stays for the next one."""
        seen = list(self.truth)
        del self.truth[: len(seen) - 1]
        worst = 0.0
        for position, _ in seen[::5]:
            q, _ = planning_joints(position)
            worst = max(worst, rcm_state(Configuration(MODEL, q), TROCAR).error)
        return worst

    def true_speed(self):
        return float(np.abs(self.truth[-1][1][:7]).max())

    def test_1_nothing_moves_before_the_tool_is_homed(self):
        self.robot.wait(lambda: self.fault and "not homed" in self.fault, START_LIMIT)
        self.assertIn("not homed", self.robot.refused("hey robot"))

    def test_2_homing_makes_it_ready(self):
        self.assertIn("rst_control/confirm", self.home_tool().message)
        self.assertTrue(self.confirm().success)
        reply = self.home_tool()
        self.assertTrue(reply.success, reply.message)
        self.robot.wait(lambda: self.fault == "")
        self.robot.activate()

    def test_2a_what_the_arm_says_of_itself_is_recorded(self):
        self.robot.wait(lambda: self.arm.get("arm: firmware"))
        self.assertEqual(self.arm["arm: faults"], "none")
        self.assertIn("1.00 1.00", self.arm["arm: soft acceleration [rad/s^2]"])

    def test_2b_hey_robot_is_refused_while_somebody_else_has_the_arm(self):
        rospy.sleep(4 * BEGINS)  # a connection that comes as it begins to lead is the bridge's own
        self.at_the_arm.publish(report(MANUALLY_CONTROLLED))
        self.robot.wait_for_state("faulted")
        self.assertEqual(self.robot.state.halt_reason_code, "arm_in_use")
        self.assertIn("connection 8", self.robot.refused("hey robot"))
        self.at_the_arm.publish(report(READY))
        self.robot.activate()

    def test_2c_an_emergency_stop_at_rest_latches_is_named_and_is_cleared(self):
        self.emergency_stop.publish()
        self.robot.wait_for_state("faulted")
        self.assertEqual(self.robot.state.halt_reason_code, "arm_fault")
        self.assertIn("base: emergency stop", self.robot.state.halt_reason)
        self.robot.activate()

    def test_3_the_first_motion_is_shown_and_has_to_be_confirmed(self):
        self.assertIn("no path was shown", self.confirm().message)
        place = self.truth[-1][0]
        self.assertIn("rst_control/confirm", self.robot.refused("tense"))
        self.robot.wait(lambda: self.preview)
        self.assertGreater(len(self.preview[0].points), 10)
        self.assertIn("dry run", self.robot.refused("tense"))
        rospy.sleep(0.5)
        np.testing.assert_allclose(self.truth[-1][0], place, atol=1e-4)
        reply = self.confirm()
        self.assertTrue(reply.success, reply.message)

    def test_4_tense_holds_the_tissue_at_its_tension(self):
        self.worst_rcm_error()
        self.robot.say_and_finish("tense", limit=60.0)
        self.assertTrue(self.gripped)
        self.assertTrue(self.robot.state.tissue_held)
        self.assertAlmostEqual(self.robot.tension, 1.0, delta=0.06)
        self.assertLess(self.worst_rcm_error(), RCM)
        self.assertIn("confirmed before", self.confirm().message)
        place = self.truth[-1][0]
        self.assertIn("assistance is active", self.home_tool().message)
        self.assertTrue(self.gripped)
        np.testing.assert_allclose(self.truth[-1][0], place, atol=1e-3)

    def test_5_pull_more_and_less_step_by_a_quarter_newton(self):
        self.robot.say_and_finish("pull more")
        self.assertAlmostEqual(self.robot.tension, 1.25, delta=0.06)
        self.robot.say_and_finish("pull less")
        self.assertAlmostEqual(self.robot.tension, 1.0, delta=0.06)

    def test_6_a_stop_in_motion_brakes_holds_and_latches(self):
        self.worst_rcm_error()
        self.robot.say("release")
        self.robot.wait(lambda: self.robot.state.phase == "ease" and self.true_speed() > 0.01)
        self.robot.stop_topic.publish()
        self.robot.wait(lambda: self.robot.state.state == "halted", 5.0)
        self.robot.wait(lambda: self.true_speed() < 1e-3, 2.0)
        self.assertLess(self.worst_rcm_error(), RCM)
        self.assertIn("halted", self.robot.refused("tense"))
        before = self.truth[-1][0]
        rospy.sleep(1.0)
        np.testing.assert_allclose(self.truth[-1][0][:7], before[:7], atol=1e-3)

    def test_6a_an_emergency_stop_in_motion_is_named_as_one(self):
        self.robot.activate()
        self.robot.say("tense")
        self.robot.wait(lambda: self.true_speed() > 0.02)
        self.emergency_stop.publish()
        self.robot.wait_for_state("faulted")
        self.assertEqual(self.robot.state.halt_reason_code, "arm_fault")
        self.assertIn("base: emergency stop", self.robot.state.halt_reason)
        self.robot.wait(lambda: self.true_speed() < 1e-3, 2.0)

    def test_7_after_hey_robot_it_is_active_and_ends(self):
        self.robot.activate()
        self.assertFalse(self.robot.state.tissue_held)
        self.assertLess(self.robot.tension, 0.02)
        self.robot.say("terminate")
        self.robot.wait_for_state("standby")
        self.assertEqual(self.fault, "")
        self.assertLess(self.worst_rcm_error(), RCM)

    def test_8_a_bridge_that_hangs_in_motion_has_the_arm_stopped_by_the_guard(
        self,
    ):
        bridge = process_of("kinova_bridge")
        heard = rospy.Subscriber("my_gen3/in/stop", Empty, self.on_stop)
        self.robot.wait(lambda: heard.get_num_connections() == 2)  # the bridge, and its guard
        self.robot.activate()
        self.robot.say("tense")
        self.robot.wait(lambda: self.true_speed() > 0.02)
        os.kill(bridge, signal.SIGSTOP)
        self.stops = 0
        try:
            self.robot.wait(lambda: self.stops > 0, 10.0)
            self.robot.wait(lambda: self.true_speed() < 1e-3, 5.0)
            place = self.truth[-1][0]
            self.robot.wait_for_state("faulted", "halted", limit=5.0)
        finally:
            os.kill(bridge, signal.SIGCONT)
        rospy.sleep(1.0)
        np.testing.assert_allclose(self.truth[-1][0][:7], place[:7], atol=1e-3)
        self.assertLess(self.true_speed(), 1e-3)
        self.assertIn("did not run", self.fault)
        self.assertIn("hey robot", self.robot.refused("release"))


if __name__ == "__main__":
    run_tests(KinovaSession, "kinova_session")

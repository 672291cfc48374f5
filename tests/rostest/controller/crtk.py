#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""A client of CRTK sees the arm, brakes it, and asks for it; one that is not named only brakes."""

import subprocess
import sys
import time

import numpy as np
import rospy
from crtk_msgs.msg import StringStamped
from crtk_msgs.msg import operating_state as operating_state_message
from geometry_msgs.msg import PoseStamped, TwistStamped

from rst_control.kinematics.configuration import Configuration, planning_joints
from rst_control.kinematics.robot_model import parse_robot
from rst_control.types import JOINTS
from tests.support.robot_client import RobotTest, run_tests

STRANGER = "--stranger"


def stranger():
    """A node that crtk.yaml does not name: publishes each line of its input as a command."""
    rospy.init_node("stranger")
    topic = rospy.Publisher("gen3/state_command", StringStamped, queue_size=10)
    while not topic.get_num_connections():
        time.sleep(0.01)
    print("connected", flush=True)
    for line in sys.stdin:
        topic.publish(StringStamped(string=line.strip()))


class Crtk(RobotTest):
    """Enabled, moved, paused, disabled."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.shown, cls.warnings = operating_state_message(), []
        cls.pose, cls.twist = PoseStamped(), TwistStamped()

        def keep(name):
            return lambda message: setattr(cls, name, message)

        rospy.Subscriber("gen3/operating_state", operating_state_message, keep("shown"))
        rospy.Subscriber("gen3/measured_cp", PoseStamped, keep("pose"))
        rospy.Subscriber("gen3/measured_cv", TwistStamped, keep("twist"))
        rospy.Subscriber("gen3/warning", StringStamped, lambda m: cls.warnings.append(m.string))
        cls.commands = rospy.Publisher("gen3/state_command", StringStamped, queue_size=10)
        cls.robot.wait(lambda: cls.commands.get_num_connections() and cls.pose.header.frame_id)

    def start_stranger(self):
        """A connected one; what it gives arrives in order."""
        words = (sys.executable, __file__, STRANGER)
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
        process = subprocess.Popen(words, text=True, bufsize=1, **pipes)
        self.addCleanup(process.communicate)  # its input ends, and so does it
        self.assertEqual(process.stdout.readline(), "connected\n")
        return process.stdin

    def enabled(self):
        """How often somebody enabled it, or said "hey robot"."""
        events = list(self.robot.events)
        return sum((e.kind, e.command) == ("accepted", "hey robot") for e in events)

    def give(self, word):
        self.commands.publish(StringStamped(string=word))

    def resumed(self):
        if self.shown.state != "ENABLED":
            self.give("resume")
        return self.shown.state == "ENABLED"

    def wait_for(self, state, is_busy=False):
        self.robot.wait(lambda: (self.shown.state, self.shown.is_busy) == (state, is_busy))

    def test_1_the_pose_is_that_of_the_measured_joints(self):
        self.wait_for("DISABLED")
        self.assertTrue(self.shown.is_homed)
        model = parse_robot(rospy.get_param("robot_description"))
        values = dict(zip(self.robot.joints.name, self.robot.joints.position, strict=True))
        joints = np.array([values[name] for name in JOINTS])
        tip = Configuration(model, planning_joints(joints)[0]).tip
        p = self.pose.pose.position
        self.assertEqual(self.pose.header.frame_id, "base_link")
        self.assertLess(np.linalg.norm(tip - [p.x, p.y, p.z]), 1e-3)

    def test_2_home_and_unknown_words_are_refused_and_nothing_changes(self):
        for word in ("home", "dance"):
            self.give(word)
            self.robot.wait(lambda word=word: any(word in w for w in self.warnings))
        self.assertEqual(self.robot.state.state, "standby")

    def test_3_enable_is_hey_robot_and_anybodys_pause_brakes_a_motion(self):
        unknown, before = self.start_stranger(), self.enabled()
        unknown.write("enable\n")
        rospy.sleep(0.5)
        self.assertEqual(self.enabled(), before)
        self.wait_for("DISABLED")
        self.assertEqual(self.shown.state, "DISABLED")
        self.give("enable")
        self.wait_for("ENABLED")
        self.robot.say("tense")
        self.robot.wait_for_state("moving")
        self.wait_for("ENABLED", is_busy=True)
        self.robot.wait(lambda: abs(self.twist.twist.linear.z) > 1e-3)
        unknown.write("pause\n")
        self.robot.wait_for_state("halted")
        self.assertEqual(self.enabled(), before + 1)  # its "enable" came before its "pause"
        self.wait_for("PAUSED")

    def test_4_what_the_controller_refuses_is_passed_on(self):
        self.robot.refused("tense")  # halted, for CRTK as for anybody
        self.assertEqual(self.robot.state.state, "halted")
        self.robot.wait(self.resumed, every=0.5)  # it is refused until the robot is at rest
        accepted = [e for e in self.robot.events if e.kind == "accepted"]
        self.assertEqual((accepted[-1].command, accepted[-1].caller), ("hey robot", "/crtk"))

    def test_5_disable_brakes_and_stands_by(self):
        self.give("disable")
        self.wait_for("DISABLED")
        self.assertIn(self.robot.state.state, ("halted", "standby"))
        self.assertFalse(self.robot.state.assistance_enabled)


if __name__ == "__main__":
    if STRANGER in sys.argv:
        stranger()
    else:
        run_tests(Crtk, "crtk_test")

#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Who sent a goal is stopped or killed in mid-motion: the robot holds until "hey robot"."""

import signal
import subprocess
import sys

import actionlib
import rospy
import rostest

from rst_control.msg import AssistAction, AssistGoal
from tests.support.robot_client import RobotTest

CLIENT = "--client"
WAIT = 60.0  # [s] for the client to find the controller


class LostClient(RobotTest):
    """The kernel's word, or the closed connection, is enough."""

    def set_off(self):
        """Let another process send a goal that moves the robot; gives that process."""
        self.robot.start_fresh()
        client = subprocess.Popen((sys.executable, __file__, CLIENT))
        self.addCleanup(client.wait)
        self.addCleanup(client.kill)
        self.robot.wait_for_motion()
        return client

    def assert_held(self, *words):
        self.robot.wait_for_state("faulted", limit=5)
        reason = self.robot.state.halt_reason
        self.assertTrue(any(reason.endswith(f"{w} during its motion") for w in words), reason)
        self.assertIn("/goal_client", reason)
        self.robot.wait(lambda: self.robot.drift(0.5) == 0.0)  # set-points are played out late here

    def test_1_killed(self):
        self.set_off().kill()
        self.assert_held("ended", "hung up")

    def test_2_stopped_and_continued(self):
        client = self.set_off()
        self.robot.wait(lambda: self.robot.state.phase in ("close", "pull"))  # it is found by then
        client.send_signal(signal.SIGSTOP)
        self.assert_held("was stopped")
        client.send_signal(signal.SIGCONT)
        self.assertEqual(self.robot.drift(1.0), 0.0)
        self.assertEqual(self.robot.state.state, "faulted")
        self.robot.activate()

    def test_3_by_hand_nobody_has_to_stay(self):
        self.robot.start_fresh()
        call = ("rosservice", "call", "/rst_control/command", "command: tense")
        subprocess.run(call, check=True, stdout=subprocess.DEVNULL)
        self.robot.wait(lambda: self.robot.finished("tense") > 0)


def send_goal():
    """The client, in its own process."""
    rospy.init_node("goal_client", anonymous=True)
    client = actionlib.SimpleActionClient("rst_control/execute", AssistAction)
    client.wait_for_server(rospy.Duration(WAIT))
    client.send_goal(AssistGoal("tense", 0.0, 0.0))
    rospy.spin()


if __name__ == "__main__":
    if CLIENT in sys.argv:
        send_goal()
    else:
        rospy.init_node("lost_client")
        rostest.rosrun("rst_control", "lost_client", LostClient, sys.argv)

#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The controller dies in the middle of a motion: the robot side holds by itself."""

import unittest

import rospy
from std_msgs.msg import String

from tests.support.robot_client import RobotClient, kill, run_tests


class RobotAlone(unittest.TestCase):
    """The controller is killed, and the robot watched."""

    def test_the_robot_holds_when_set_points_stop(self):
        robot, faults = RobotClient(), []
        rospy.Subscriber("robot/fault", String, lambda message: faults.append(message.data))
        robot.start_fresh()
        robot.say("tense")
        robot.wait_for_motion()
        kill("controller")
        place = robot.measured()
        robot.wait(lambda: robot.drift(0.1) < 1e-4, limit=3)
        self.assertLess(robot.away(place), 0.05)
        robot.wait(lambda: any("set-points stopped" in fault for fault in faults))
        self.assertLess(robot.drift(0.5), 1e-3)


if __name__ == "__main__":
    run_tests(RobotAlone, "robot_alone")

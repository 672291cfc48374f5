#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""A controller that is started anew goes on from where the robot holds, whatever that is."""

import unittest

import rospy
from geometry_msgs.msg import Point

from rst_control.srv import SetGraspPoint
from tests.support.robot_client import Halted, RobotClient, kill, run_tests

FINGERS = slice(8, 10)
ATTEMPTS = 4  # at stopping a release halfway
HALF_OPEN = (0.03, 0.055)  # [rad]: no longer closed, and tissue is still held


class RestartedController(unittest.TestCase):
    """Killed at rest, with the jaws as a release left them that was stopped halfway."""

    def test_it_moves_nothing_and_goes_on(self):
        robot = RobotClient()
        robot.activate()
        self._set_grasp_point(robot)
        self._release_halfway(robot)
        before = robot.joints.position
        kill("controller")
        robot.wait(lambda: robot.state.state == "standby")
        self.assertEqual(robot.state.grasp_point_source, rospy.get_name())
        rospy.sleep(1.0)
        self.assertLess(robot.away(before), 2e-5)
        robot.activate()
        self.assertTrue(robot.state.tissue_held)
        robot.say_and_finish("release")
        self.assertFalse(robot.state.tissue_held)

    def _set_grasp_point(self, robot):
        """It counts after the restart, too."""
        rospy.wait_for_service("rst_control/set_grasp_point", 60.0)
        service = rospy.ServiceProxy("rst_control/set_grasp_point", SetGraspPoint)
        reply = service(position=Point(0.476, -0.024, 0.269))
        self.assertTrue(reply.accepted, reply.message)
        robot.wait(lambda: robot.state.grasp_point_source == rospy.get_name())

    def _release_halfway(self, robot):
        """Again where a loaded machine stops it too late, or halts it."""
        for _ in range(ATTEMPTS):
            robot.start_fresh()
            try:
                robot.say_and_finish("tense")
            except Halted:
                continue
            robot.say("release")
            robot.wait(lambda: self._opening(robot) > HALF_OPEN[0])
            robot.say("stop")
            robot.wait_for_state("halted")
            robot.wait_for_rest()
            if self._opening(robot) < HALF_OPEN[1]:
                break
        self.assertTrue(HALF_OPEN[0] < self._opening(robot) < HALF_OPEN[1])
        self.assertTrue(robot.state.tissue_held)

    def _opening(self, robot):
        return sum(robot.joints.position[FINGERS])


if __name__ == "__main__":
    run_tests(RestartedController, "restarted_controller")

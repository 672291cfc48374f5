#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The controller dies in the middle of a motion: the robot side holds by itself."""

import unittest

from tests.support.robot_client import RobotClient, kill, run_tests


class RobotAlone(unittest.TestCase):
    """The controller is killed, and the robot watched."""

    def test_the_robot_holds_when_set_points_stop(self):
        robot = RobotClient()
        robot.start_fresh()
        robot.say("tense")
        robot.wait_for_motion()
        kill("controller")
        robot.wait(lambda: robot.drift(0.1) < 1e-4, limit=3)
        self.assertLess(robot.drift(0.5), 1e-3)


if __name__ == "__main__":
    run_tests(RobotAlone, "robot_alone")

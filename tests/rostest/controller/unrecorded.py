#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Without a recorder, by the setting `ignore`: everything works, and it was said once."""

import unittest

import rospy
from diagnostic_msgs.msg import DiagnosticArray
from rosgraph_msgs.msg import Log

from tests.support.robot_client import RobotClient, run_tests


class Unrecorded(unittest.TestCase):
    """The controller was told that nobody records."""

    def test_the_robot_works_and_the_log_says_once_that_nothing_is_recorded(self):
        said, statuses = [], {}
        rospy.Subscriber("/rosout_agg", Log, lambda m: said.append(m.msg))
        rospy.Subscriber(
            "/diagnostics",
            DiagnosticArray,
            lambda m: statuses.update({s.name: s.message for s in m.status}),
        )
        robot = RobotClient()
        robot.start_fresh()
        robot.say_and_finish("tense")
        robot.say_and_finish("release")
        words = "not recorded: no recorder was ever heard"
        robot.wait(lambda: statuses.get("rst_control: recording") == words)
        told = [line for line in said if "not recorded" in line]
        self.assertLessEqual(len(told), 1)  # none if it was said before this test listened
        self.assertTrue(all(line == f"{words}; ignored, as it was set" for line in told))
        robot.leave()


if __name__ == "__main__":
    run_tests(Unrecorded, "unrecorded")

#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The operator's page: what comes in by topic is served, and its stop goes out by topic."""

import json
import unittest
from urllib.request import Request, urlopen

import rospy
from std_msgs.msg import Empty

from rst_control.msg import ControllerState
from support.waiting import PATIENCE, wait_until
from tests.support.robot_client import run_tests


class Display(unittest.TestCase):
    """The page as a browser has it; this test plays the controller."""

    @classmethod
    def setUpClass(cls):
        cls.stops = []
        rospy.Subscriber("rst_control/stop", Empty, cls.stops.append)
        wait_until(lambda: rospy.has_param("display/page"))
        cls.page = rospy.get_param("display/page")
        cls.states = rospy.Publisher("rst_control/state", ControllerState, queue_size=2)
        wait_until(lambda: cls.states.get_num_connections() > 0)

    def newest(self):
        """The next snapshot that a viewer gets."""
        with urlopen(f"{self.page}/events", timeout=PATIENCE) as events:
            line = next(line for line in events if line.startswith(b"data:"))
        return json.loads(line.removeprefix(b"data:"))

    def test_1_the_page_is_on_loopback(self):
        self.assertTrue(self.page.startswith("http://127.0.0.1:"), self.page)
        with urlopen(self.page, timeout=PATIENCE) as answer:
            self.assertIn("default-src", answer.headers["Content-Security-Policy"])

    def test_2_the_robots_state_is_shown_with_its_age(self):
        def is_shown():
            self.states.publish(ControllerState(state="moving", phase="pull", command="tense"))
            robot = self.newest()["robot"]
            return robot and (robot["state"], robot["phase"]) == ("moving", "pull")

        wait_until(is_shown)
        rospy.sleep(0.7)
        self.assertGreater(self.newest()["robot"]["age"], 0.5)

    def test_3_its_stop_needs_no_token(self):
        with urlopen(Request(f"{self.page}/act/stop", method="POST"), timeout=PATIENCE) as answer:
            self.assertFalse(json.load(answer)["done"])  # no controller answers its service here
        wait_until(lambda: self.stops)


if __name__ == "__main__":
    run_tests(Display, "display_test")

#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The operator's page in a headless browser, beside robot, controller, voice node and alarms."""

import asyncio
import os
import re
import sys
from pathlib import Path

import rospy
from geometry_msgs.msg import Point, PointStamped

from rst_control.config import load_simulation_config
from rst_control.ros.simulator.pictures import endoscope_messages
from rst_control.srv import SetGraspPoint
from rst_control.tissue.sheet import rest_points
from support.browser import MISSING, Browser, find_browser
from support.waiting import wait_until
from tests.support.microphone import Microphone
from tests.support.page import click, click_picture, enter, text
from tests.support.robot_client import RobotTest, kill, run_tests
from voice_assist.msg import Utterance
from voice_assist.ros.display.endoscope import camera_of


class PageInBrowser(RobotTest):
    """One browser is connected while the session runs."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.microphone, cls.heard = Microphone(), []
        rospy.Subscriber("voice_assist/utterance", Utterance, cls.heard.append)
        wait_until(lambda: rospy.has_param("display/page"))
        cls.loop = asyncio.Runner()
        cls.browser = cls.loop.run(Browser().__aenter__())
        cls.loop.run(cls.browser.open(rospy.get_param("display/page")))
        cls.wait(f"{text('state')} !== 'No news'")

    @classmethod
    def tearDownClass(cls):
        cls.loop.run(cls.browser.__aexit__())
        cls.loop.close()
        cls.microphone.timer.shutdown()
        super().tearDownClass()

    @classmethod
    def ask(cls, script):
        return cls.loop.run(cls.browser.evaluate(script))

    @classmethod
    def wait(cls, script):
        return cls.loop.run(cls.browser.until(script))

    def said(self, name):
        return self.ask(text(name))

    def wait_for_text(self, name, words):
        try:
            self.wait(f"{text(name)}.includes({words!r})")
        except RuntimeError as late:
            raise AssertionError(f"{name} says {self.said(name)!r}: {late}") from None

    def test_1_a_spoken_word_is_shown_with_what_it_does(self):
        while not self.heard:  # the voice node starts up
            self.microphone.say("good morning")
            rospy.sleep(1.0)
        self.wait_for_text("utterance-why", "not taken")
        self.microphone.say("hey robot")
        self.wait_for_text("utterance-words", "hey robot")
        self.wait_for_text("utterance-why", "taken from")
        self.wait_for_text("state", "Ready")
        self.wait_for_text("words", "tense")
        self.assertEqual(self.ask("document.getElementById('level').ariaValueMax"), "0")

    def test_2_states_of_a_motion_and_the_stop_button(self):
        self.robot.start_fresh()
        self.robot.say("tense")
        self.wait(f"{text('state')}.includes('Moving') && document.title.startsWith('Moving')")
        self.ask(click("stop"))
        self.robot.wait_for_state("halted")
        self.wait_for_text("state", "Halted")
        self.wait_for_text("why", "/display")
        self.wait_for_text("alert", "hey robot")  # its next step, to screen readers
        self.assertEqual(self.ask("document.getElementById('robot').dataset.state"), "halted")
        self.assertTrue(self.ask("!document.getElementById('alarm').hidden"))
        self.wait("document.getElementById('picture').naturalWidth > 100")

    def test_3_a_click_into_the_picture_sets_the_grasp_point(self):
        grasp_points = []
        rospy.Subscriber(
            "rst_control/grasp_point", PointStamped, lambda m: grasp_points.append(m.point)
        )
        self.robot.start_fresh()
        self.wait("!document.getElementById('pick').hidden")
        self.ask(click("pick"))
        self.wait_for_text("act-words", "Enter the token first")
        self.enter_token()
        point, (x, y) = node_beside_the_grasp_point()
        self.ask(click("pick"))
        self.click_picture(x, y, "Set: grasp point")
        self.robot.wait(lambda: len(grasp_points) > 1)
        found = grasp_points[-1]
        for wanted, is_there in zip(point, (found.x, found.y, found.z), strict=True):
            self.assertAlmostEqual(is_there, wanted, places=6)
        self.ask(click("pick"))
        self.click_picture(0.2, 0.5, "Not set: that is outside the endoscope")  # the overview
        first = grasp_points[0]
        set_back = rospy.ServiceProxy("rst_control/set_grasp_point", SetGraspPoint)
        self.assertTrue(set_back(position=Point(first.x, first.y, first.z)).accepted)

    def enter_token(self):
        printed = Path(os.environ["ROS_HOME"]).with_name("said.txt").read_text(encoding="utf-8")
        token = re.findall(r"token: (\w+)", printed)[-1]
        self.ask(enter(token))

    def click_picture(self, x, y, words):
        """Click into the first picture that is not old, and wait for what the page says of it."""
        self.wait(f"{click_picture(x, y)}, !{text('pick-words')}.includes('picture is old')")
        self.wait_for_text("pick-words", words)

    def test_4_a_killed_node_is_named_and_its_return_too(self):
        kill("/alarms")
        self.wait_for_text("alarm-cause", "No alarms are watched")
        self.wait("document.getElementById('alarm').hidden")

    def test_5_a_lost_connection_is_said_and_comes_back(self):
        kill("/display")
        self.wait("!document.getElementById('lost').hidden")
        self.assertIn("nothing below is as it is now", self.said("lost-words"))
        self.wait("document.getElementById('lost').hidden")
        self.wait_for_text("state", "Ready")

    def test_6_its_scripts_raised_no_error(self):
        raised = [one for one in self.browser.errors if "network" not in one]
        self.assertEqual(raised, [])


def node_beside_the_grasp_point():
    """A node on the upper edge of the sheet, and where it is in the picture, as shares of it."""
    config = load_simulation_config()
    x, y, z = config.scene.grasp_point
    nodes = rest_points(config.scene.tissue)
    point = nodes[abs(nodes - [x + 0.008, y, z]).sum(axis=1).argmin()]
    camera = camera_of(*endoscope_messages(config))
    u, v, w = camera.matrix @ (camera.pose[:3, :3].T @ (point - camera.pose[:3, 3]))
    return point.tolist(), (u / w / camera.size[0], v / w / camera.size[1])


if __name__ == "__main__":
    if not find_browser():
        print(f"skipped: {MISSING}")
        sys.exit()
    run_tests(PageInBrowser, "page_in_browser")

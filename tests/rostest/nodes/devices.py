#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The devices node with the simulated theatre; this plays the voice node, by its name."""

import subprocess
import sys
import threading
import unittest
from pathlib import Path

import rospy
from actionlib_msgs.msg import GoalID, GoalStatus
from std_msgs.msg import Bool, Empty, Float64
from std_srvs.srv import Trigger, TriggerResponse

from rst_control.msg import AssistActionGoal, AssistActionResult
from support.waiting import PATIENCE, wait_until
from tests.support.robot_client import run_tests
from voice_assist.config.devices import DeviceCallConfig
from voice_assist.msg import DeviceCall, Utterance
from voice_assist.ros.devices.targets import make_target

THEATRE = Path(__file__).resolve().parents[3] / "examples" / "theatre_devices.py"


class Devices(unittest.TestCase):
    """The tests run in the order of their names."""

    @classmethod
    def setUpClass(cls):
        cls.light, cls.pressure, cls.recorder, cls.results = [], [], [], []
        rospy.Subscriber("/theatre/light/state", Bool, lambda m: cls.light.append(m.data))
        rospy.Subscriber(
            "/theatre/insufflator/pressure", Float64, lambda m: cls.pressure.append(m.data)
        )
        rospy.Subscriber(
            "/theatre/endoscope/is_recording", Bool, lambda m: cls.recorder.append(m.data)
        )
        subscriber = rospy.Subscriber("voice_assist/device", DeviceCall, cls.results.append)
        cls.words = rospy.Publisher("voice_assist/utterance", Utterance, queue_size=10)
        cls.stops = rospy.Publisher("rst_control/stop", Empty, queue_size=1)
        wait_until(lambda: rospy.has_param("/devices/calls"))
        wait_until(lambda: len(cls.followers()) > 0, "the devices node")
        wait_until(lambda: subscriber.get_num_connections() > 0, "results of the devices node")
        cls.theatre = None

    @classmethod
    def followers(cls):
        """Nodes that follow this one's words."""
        state = rospy.get_master().getSystemState()[2][1]
        there = next((n for topic, n in state if topic == "/voice_assist/utterance"), [])
        is_connected = cls.words.get_num_connections() >= len(there)
        return [node for node in there if node == "/devices" and is_connected]

    @classmethod
    def tearDownClass(cls):
        cls.end_theatre()

    @classmethod
    def end_theatre(cls):
        if cls.theatre is not None:
            cls.theatre.terminate()
            cls.theatre.wait()
            cls.theatre = None

    def say(self, command, transcript=""):
        """Report a decision; returns the result of its call."""
        count = len(self.results)
        self.words.publish(Utterance(command=command, transcript=transcript or command))
        wait_until(lambda: len(self.results) > count, f"a result of {command!r}")
        return self.results[-1]

    def test_1_a_device_that_is_not_there_fails_in_words(self):
        self.assertFalse(self.say("light on").is_done)
        self.assertIn("/theatre/light", self.results[-1].message)
        self.assertIn("nobody listens", self.say("take this down").message)

    def test_2_words_reach_services_and_topics(self):
        type(self).theatre = subprocess.Popen([sys.executable, str(THEATRE)])
        rospy.wait_for_service("/theatre/insufflator/lower", PATIENCE)
        self.assertTrue(self.say("light on").is_done)
        self.assertTrue(self.say("take this down").is_done)
        wait_until(lambda: self.light == [True] and self.recorder == [True])

    def test_3_a_stop_undoes_what_says_so_and_nothing_else(self):
        self.assertEqual(self.say("higher pressure").message, "13 mmHg, allowed 8 to 15")
        self.stops.publish(Empty())
        wait_until(lambda: self.pressure == [13.0, 12.0])
        wait_until(lambda: self.results[-1].phrase == "pressure down")
        self.assertEqual(self.light, [True])

    def test_4_a_device_that_refuses_is_quoted(self):
        for _ in range(3):
            self.say("higher pressure")
        refused = self.say("higher pressure")
        self.assertFalse(refused.is_done)
        self.assertEqual(refused.message, "16 mmHg, allowed 8 to 15")

    def test_5_other_words_and_words_that_were_not_taken_call_nothing(self):
        count = len(self.results)
        for command, transcript in (("tense", "tense"), ("", "light on"), ("door", "door")):
            self.words.publish(Utterance(command=command, transcript=transcript))
        self.assertEqual(self.say("go dark").phrase, "go dark")
        self.assertEqual(len(self.results), count + 1)

    def test_6_a_service_of_another_type_and_one_that_hangs_fail_in_words(self):
        self.end_theatre()
        hang, called = threading.Event(), []
        self.addCleanup(hang.set)
        other = rospy.Service("/theatre/light", Trigger, lambda _: TriggerResponse())

        def wait(request):
            called.append(request)
            return hang.wait(PATIENCE) and TriggerResponse()

        slow = rospy.Service("/theatre/insufflator/lower", Trigger, wait)
        self.addCleanup(slow.shutdown)
        self.addCleanup(other.shutdown)
        self.assertIn("md5", self.say("light on").message)
        late = "no answer within 2 s; it may still be carried out"
        self.assertEqual(self.say("pressure down").message, late)
        self.assertEqual(len(called), 1)

    def test_7_an_action_succeeds_or_is_cancelled_when_it_takes_too_long(self):
        given = {"phrase": "tidy up", "kind": "action", "target": "/theatre/robot_vacuum"}
        given |= {"type": "rst_control/Assist", "arguments": "{command: clean}", "within": 1.0}
        target = make_target(DeviceCallConfig(**given, on_stop=""))
        self.assertIn("nobody serves", target.call().words)
        goals, cancelled = [], []
        result = rospy.Publisher("/theatre/robot_vacuum/result", AssistActionResult, queue_size=1)

        def serve(goal):
            goals.append(goal.goal.command)
            if len(goals) == 1:
                done = GoalStatus(goal_id=goal.goal_id, status=GoalStatus.SUCCEEDED, text="clean")
                result.publish(AssistActionResult(status=done))

        rospy.Subscriber("/theatre/robot_vacuum/goal", AssistActionGoal, serve)
        rospy.Subscriber("/theatre/robot_vacuum/cancel", GoalID, cancelled.append)
        wait_until(lambda: result.get_num_connections() > 0)
        first, second = target.call(), target.call()
        self.assertEqual((first.is_done, first.words), (True, "clean"))
        self.assertEqual(second.words, "no result within 1 s; cancelled")
        wait_until(lambda: cancelled)
        self.assertEqual(goals, ["clean", "clean"])


if __name__ == "__main__":
    run_tests(Devices, "voice_assist")

#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The stop guard's wiring: beats in, stops out."""

import time
import unittest

import rospy
from kortex_driver.msg import Base_JointSpeeds
from std_msgs.msg import Empty

from rst_control.msg import BridgeBeat
from support.waiting import wait_until
from tests.support.robot_client import run_tests


class KinovaGuard(unittest.TestCase):
    """In the order of their names."""

    @classmethod
    def setUpClass(cls):
        cls.stops, cls.alive, cls.speeds = [], [], []
        rospy.Subscriber(
            "my_gen3/in/joint_velocity", Base_JointSpeeds, cls.speeds.append, tcp_nodelay=True
        )
        rospy.Subscriber("my_gen3/in/stop", Empty, cls.stops.append, tcp_nodelay=True)
        alive = rospy.Subscriber("kinova_guard/alive", Empty, cls.alive.append, tcp_nodelay=True)
        cls.beat = rospy.Publisher("kinova_bridge/beat", BridgeBeat, queue_size=1, tcp_nodelay=True)
        ways = (alive, cls.beat)
        wait_until(lambda: all(way.get_num_connections() for way in ways), "the guard")

    def beat_until_answered(self):
        before = len(self.alive)

        def beat():
            self.beat.publish(BridgeBeat())
            return len(self.alive) > before

        wait_until(beat, "the guard's own beat")

    def test_1_while_nobody_was_heard_it_stops_nothing_and_is_no_guard(self):
        time.sleep(0.5)
        self.assertEqual(self.stops, [])
        self.assertEqual(self.alive, [])

    def test_2_silence_after_beats_stops_the_arm_again_and_again(self):
        self.beat_until_answered()
        wait_until(lambda: len(self.stops) >= 5, "five stops")

    def test_3_and_then_leaves_the_arm_to_others_and_is_no_guard(self):
        time.sleep(4.0)
        before = len(self.stops)
        time.sleep(1.0)
        self.assertEqual(len(self.stops), before)
        alive = len(self.alive)
        time.sleep(1.0)
        self.assertEqual(len(self.alive), alive)

    def test_4_an_arm_that_was_led_is_braked_along_its_course_before_it_is_stopped(self):
        before, row = len(self.stops), [0.1, 0.05, 0.0, 0.0, 0.0, 0.0, 0.0]
        still = [0.0] * 7
        course = {"position": still, "velocity": row, "sent": row, "goal": still, "speed": row}
        self.assertEqual(self.speeds, [])
        self.beat.publish(BridgeBeat(is_leading=True, age=0.0, bend=still, **course))
        wait_until(lambda: len(self.stops) > before, "a stop")
        sent = [speed.joint_speeds[0].value for speed in self.speeds]
        self.assertGreater(len(sent), 3)
        self.assertAlmostEqual(sent[-1], 0.0, delta=1e-5)
        for speed in self.speeds:  # all joints keep to their common way
            first, second, *_ = (joint.value for joint in speed.joint_speeds)
            self.assertAlmostEqual(second, 0.5 * first, delta=1e-3)


if __name__ == "__main__":
    run_tests(KinovaGuard, "stop_guard")

#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The stop guard's wiring: beats in, stops out. This node is the bridge, and the arm's driver."""

import math
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
        cls.stops, cls.alive, cls.speeds, cls.alive_of_left = [], [], [], []
        heard = (
            ("my_gen3/in/joint_velocity", Base_JointSpeeds, cls.speeds.append),
            ("my_gen3/in/stop", Empty, cls.stops.append),
            ("kinova_guard/alive", Empty, cls.alive.append),
            ("guard_of_left_arm/alive", Empty, cls.alive_of_left.append),
            ("left_arm/in/joint_velocity", Base_JointSpeeds, lambda _: None),
            ("left_arm/in/stop", Empty, lambda _: None),
        )
        ways = [rospy.Subscriber(*one, tcp_nodelay=True) for one in heard]
        cls.stop = ways[1]
        cls.beat = rospy.Publisher("kinova_bridge/beat", BridgeBeat, queue_size=1, tcp_nodelay=True)
        wait_until(lambda: all(way.get_num_connections() for way in ways), "topics of both guards")
        wait_until(lambda: cls.beat.get_num_connections() == 2, "both guards")

    def beat_until_answered(self):
        before = len(self.alive)

        def beat():
            self.beat.publish(BridgeBeat())
            return len(self.alive) > before

        wait_until(beat, "the guard's own beat")

    def has_slowed_down(self):
        last = self.speeds[-1].joint_speeds[0].value if len(self.speeds) > 3 else math.inf
        return abs(last) < 1e-5

    def alive_within(self, seconds):
        """Beats of the guard for a bridge that beats."""
        before, end = len(self.alive), time.monotonic() + seconds
        while time.monotonic() < end:
            self.beat.publish(BridgeBeat())
            time.sleep(0.01)
        return len(self.alive) - before

    def test_1_while_nobody_was_heard_it_stops_nothing_and_is_no_guard(self):
        time.sleep(0.5)
        self.assertEqual(self.stops, [])
        self.assertEqual(self.alive, [])

    def test_2_silence_after_beats_stops_the_arm_again_and_again(self):
        self.beat_until_answered()
        wait_until(lambda: len(self.stops) >= 5, "five stops")

    def test_3_and_then_leaves_the_arm_to_others_and_is_no_guard(self):
        def is_quiet():
            said = len(self.stops), len(self.alive)
            time.sleep(1.0)
            return (len(self.stops), len(self.alive)) == said

        wait_until(is_quiet, "a second without a stop and without a beat")

    def test_4_an_arm_that_was_led_is_braked_along_its_course_before_it_is_stopped(self):
        before, row = len(self.stops), [0.1, 0.05, 0.0, 0.0, 0.0, 0.0, 0.0]
        still = [0.0] * 7
        course = {"position": still, "velocity": row, "sent": row, "goal": still, "speed": row}
        self.assertEqual(self.speeds, [])
        self.beat.publish(BridgeBeat(is_leading=True, age=0.0, bend=still, **course))
        wait_until(lambda: len(self.stops) > before + 3, "stops")  # speeds come another way
        wait_until(self.has_slowed_down, "more than three speeds, the last of them nothing")
        sent = [speed.joint_speeds[0].value for speed in self.speeds]
        self.assertGreater(len(sent), 3)
        self.assertAlmostEqual(sent[-1], 0.0, delta=1e-5)
        for speed in self.speeds:  # all joints keep to their common way
            first, second, *_ = (joint.value for joint in speed.joint_speeds)
            self.assertAlmostEqual(second, 0.5 * first, delta=1e-3)

    def test_5_a_guard_for_another_arm_is_no_guard(self):
        """It is connected to the topics of its arm, by a node that is not its driver."""
        self.assertGreater(self.alive_within(2.0), 0)
        self.assertEqual(self.alive_of_left, [])

    def test_6_a_guard_that_the_driver_lost_is_none(self):
        self.stop.unregister()
        wait_until(lambda: self.alive_within(0.5) == 0, "no beat of the guard")
        rospy.Subscriber("my_gen3/in/stop", Empty, self.stops.append, tcp_nodelay=True)
        self.beat_until_answered()


if __name__ == "__main__":
    run_tests(KinovaGuard, "stop_guard")

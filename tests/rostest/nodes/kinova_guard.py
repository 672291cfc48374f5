#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The stop guard's wiring: beats in, stops out."""

import sys
import time
import unittest

import rospy
import rostest
from std_msgs.msg import Empty

from support.waiting import wait_until


class KinovaGuard(unittest.TestCase):
    """In the order of their names."""

    @classmethod
    def setUpClass(cls):
        cls.stops, cls.alive = [], []
        rospy.Subscriber("my_gen3/in/stop", Empty, cls.stops.append, tcp_nodelay=True)
        rospy.Subscriber("kinova_guard/alive", Empty, cls.alive.append, tcp_nodelay=True)
        cls.beat = rospy.Publisher("kinova_bridge/beat", Empty, queue_size=1, tcp_nodelay=True)
        wait_until(lambda: cls.alive and cls.beat.get_num_connections(), "the guard")

    def test_1_it_stops_nothing_while_nobody_was_heard(self):
        time.sleep(0.5)
        self.assertEqual(self.stops, [])

    def test_2_silence_after_beats_stops_the_arm_again_and_again(self):
        for _ in range(5):
            self.beat.publish(Empty())
            time.sleep(0.01)
        wait_until(lambda: len(self.stops) >= 5, "five stops")

    def test_3_and_then_leaves_the_arm_to_others(self):
        time.sleep(4.0)
        before = len(self.stops)
        time.sleep(1.0)
        self.assertEqual(len(self.stops), before)
        alive = len(self.alive)
        time.sleep(1.0)
        self.assertGreater(len(self.alive), alive)


if __name__ == "__main__":
    rospy.init_node("stop_guard")
    rostest.rosrun("rst_control", "stop_guard", KinovaGuard, sys.argv)

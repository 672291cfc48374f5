#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The pedal node with a joy on a topic; this plays the controller."""

import subprocess
import sys
import unittest

import rospy
from diagnostic_msgs.msg import DiagnosticArray
from sensor_msgs.msg import Joy
from std_msgs.msg import Bool, Empty

from rst_control.srv import Command, CommandResponse
from support.waiting import wait_until
from tests.support.robot_client import run_tests

REST, HELD = -1.0, 1.0  # of the dead-man's axis
OTHER_DRIVER = f"""
import rospy
from sensor_msgs.msg import Joy
rospy.init_node("other_joy")
joy = rospy.Publisher("joy", Joy, queue_size=10)
while not joy.get_num_connections():
    rospy.sleep(0.01)
for dead_man in ({REST}, {HELD}):
    joy.publish(Joy(buttons=[0, 0, 1, 0], axes=[dead_man]))
rospy.spin()
"""


class Pedal(unittest.TestCase):
    """The tests run in the order of their names."""

    @classmethod
    def setUpClass(cls):
        cls.stops, cls.commands, cls.gate, cls.health, cls.held = [], [], [], [], []
        stops = rospy.Subscriber("rst_control/stop", Empty, cls.note_stop)
        rospy.Subscriber("voice_assist/talk", Bool, lambda m: cls.gate.append(m.data))
        held = rospy.Subscriber("rst_control/dead_man", Bool, lambda m: cls.held.append(m.data))
        rospy.Subscriber("/diagnostics", DiagnosticArray, cls.note_health)
        rospy.Service("rst_control/command", Command, cls.take)
        cls.joy = rospy.Publisher("joy", Joy, queue_size=10)
        links = (cls.joy, stops, held)  # without the last it commands nothing but a stop
        wait_until(lambda: all(link.get_num_connections() for link in links))

    @classmethod
    def note_stop(cls, message):
        if message._connection_header["callerid"] == "/pedal":
            cls.stops.append(message)

    @classmethod
    def note_health(cls, message):
        cls.health += [s.message for s in message.status if s.name.endswith(": pedal")]

    @classmethod
    def take(cls, request):
        cls.commands.append((request.command, request._connection_header["callerid"]))
        return CommandResponse(True, "", "")

    def step(self, *pressed, dead_man=REST, age=None):
        message = Joy(buttons=[int(i in pressed) for i in range(4)], axes=[dead_man])
        if age is not None:
            message.header.stamp = rospy.Time.from_sec(rospy.get_time() - age)
        self.joy.publish(message)
        rospy.sleep(0.1 if pressed else 0.8)  # a press counts after a release of 0.05 s, as heard

    def test_1_a_press_from_the_start_does_nothing_and_a_later_one_commands(self):
        self.step(1)
        self.step()
        self.step(1)
        wait_until(lambda: self.commands)
        self.step()
        self.step(0)
        wait_until(lambda: len(self.commands) == 2 and self.stops)
        self.assertEqual(self.commands, [("pull more", "/pedal"), ("stop", "/pedal")])
        self.step()
        self.commands.clear()
        for age, button in ((10.0, 1), (0.0, 1), (10.0, 0)):
            self.step(button, age=age)
            self.step()
        wait_until(lambda: len(self.commands) == 2)  # the old press but for a stop is dropped
        self.assertEqual([command for command, _ in self.commands], ["pull more", "stop"])

    def test_2_the_gate_follows_its_pedal(self):
        for pressed, is_open in (((2,), True), ((), False)):
            self.step(*pressed)
            self.gate.clear()
            wait_until(lambda is_open=is_open: self.gate[-1:] == [is_open])

    def test_3_a_released_dead_man_brakes(self):
        self.step(dead_man=HELD)
        self.stops.clear()
        self.step(3, dead_man=HELD)  # a button that nothing is bound to
        self.step(dead_man=REST)
        wait_until(lambda: self.stops)

    def test_4_the_controller_is_told_again_and_again_whether_it_is_held(self):
        for position, is_held in ((HELD, True), (REST, False)):
            self.step(dead_man=position)
            self.held.clear()
            wait_until(lambda: len(self.held) > 2)
            self.assertEqual(set(self.held), {is_held})

    def test_5_a_driver_that_is_killed_releases_its_presses_beside_another(self):
        self.step()
        wait_until(lambda: self.gate[-1:] == [False])
        driver = subprocess.Popen([sys.executable, "-c", OTHER_DRIVER])
        self.addCleanup(driver.wait)
        self.addCleanup(driver.kill)
        wait_until(lambda: self.gate[-1:] == [True])
        self.stops.clear()
        driver.kill()
        wait_until(lambda: self.stops)
        wait_until(lambda: self.gate[-1:] == [False])
        wait_until(lambda: any("/other_joy publishes joy no more" in w for w in self.health))
        self.step()  # the other is there, and what it presses counts after a release

    def test_6_a_joy_that_vanishes_is_named_brakes_and_closes_the_gate(self):
        self.step(2, dead_man=REST)
        self.step(2, dead_man=HELD)
        wait_until(lambda: self.gate[-1:] == [True])
        self.stops.clear()
        self.joy.unregister()
        wait_until(lambda: self.stops)
        wait_until(lambda: self.gate[-1:] == [False])
        wait_until(lambda: any("/pedal_test publishes joy no" in w for w in self.health))


if __name__ == "__main__":
    run_tests(Pedal, "pedal_test")

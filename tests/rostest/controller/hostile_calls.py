#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Floods, junk and strangers at every service, topic and port: nothing moves by them, a stop stops.

How well the loop keeps its times meanwhile is measured by bench/safety/flood.py.
"""

import random
import struct
from contextlib import ExitStack, suppress

import rospy
from diagnostic_msgs.msg import DiagnosticArray
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool, String, Time

from rst_control.msg import AssistActionGoal
from support.raw_peer import Flood, Peer, process_of, resident_memory
from tests.support.robot_client import RobotTest, run_tests

FLOOD_TIME = 2.0  # [s]
GROWTH = 60.0  # [MB] that the controller may hold more after a second flood than after the first
JUNK = ("dance", "tense now", "t\u0435nse", "", "x" * 300)
MEGA = 10_000_000


def junk(kind, rng):
    """A message of a type, with any bytes in place of its content."""

    class Junk(kind):
        _has_header = False

        def __init__(self):
            pass

        def serialize(self, buff):
            buff.write(rng.randbytes(rng.choice((0, 1, 7, 40, 400, 5000, 200_000))))

    return Junk


class HostileCalls(RobotTest):
    """The tests run in the order of their names and build on one robot."""

    @classmethod
    def setUpClass(cls):
        cls.strangers = ""
        super().setUpClass()
        cls.ticks = []
        cls.diagnostics = rospy.Subscriber("/diagnostics", DiagnosticArray, cls.take_diagnostics)
        cls.process = process_of("controller")

    @classmethod
    def take_diagnostics(cls, array):
        for status in array.status:
            for value in status.values:
                if status.name == "rst_control: strangers":
                    cls.strangers = status.message
                if value.key == "ticks":
                    cls.ticks.append(int(value.value))

    def assert_moves_and_stops(self):
        self.robot.start_fresh()
        self.robot.say("tense")
        self.robot.wait_for_motion()
        self.robot.say("Stop.")
        self.robot.wait_for_state("halted", limit=5)
        self.robot.wait(lambda: self.robot.drift(0.1) < 1e-4, limit=5)

    def assert_loop_runs(self):
        seen = len(self.ticks)
        self.robot.wait(lambda: len(self.ticks) > seen + 1)
        self.assertGreater(self.ticks[-1], self.ticks[seen])

    def test_1_fifty_callers_who_flood_move_nothing(self):
        self.robot.wait_for_state("standby")
        with Flood((*JUNK, "tense", "pull more")) as flood:
            before = self.robot.joints.position
            self.assert_loop_runs()  # for a second or two
            self.assertEqual(self.robot.state.state, "standby")
            self.assertLess(self.robot.away(before), 1e-4)
        self.assertGreater(flood.offered, 0)

    def test_2_in_a_flood_others_are_heard_and_a_stop_stops(self):
        with Flood(JUNK):
            self.assert_moves_and_stops()

    def test_3_a_caller_who_floods_is_refused_with_the_limits_and_may_still_stop(self):
        with Peer("/hasty") as peer:
            self.assertEqual(peer.greet()["type"], "rst_control/Command")
            answers = [peer.call("dance")]
            while len(answers) < 500 and "too many calls" not in answers[-1][1]:
                answers.append(peer.call("dance"))
            refused = [words for _, words in answers if "too many calls from /hasty" in words]
            self.assertTrue(refused, answers[-1])
            self.assertIn("per second", refused[-1])
            self.assertTrue(peer.call("stop")[0])
        self.robot.wait_for_state("halted")

    def test_4_a_flood_leaves_no_memory_behind(self):
        held = []
        for _ in range(2):
            with Flood(JUNK):
                rospy.sleep(FLOOD_TIME)
            rospy.sleep(1.0)
            held.append(resident_memory(self.process))
        self.assertLess(held[1], held[0] + GROWTH)

    def test_5_ten_megabytes_are_answered_by_their_length_and_not_kept(self):
        before = resident_memory(self.process)
        with Peer("/long") as peer:
            peer.greet()
            for text in ("a" * MEGA, "tense" + " " * MEGA, b"\xff" * MEGA):
                accepted, words = peer.call(text)
                self.assertFalse(accepted)
                self.assertIn(f"{len(text)} bytes, allowed: 200", words)
            self.assertTrue(peer.call("stop " * (MEGA // 5))[0])
        self.assertLess(resident_memory(self.process), before + GROWTH)
        self.robot.wait_for_state("halted")

    def test_6_strangers_at_the_port_keep_nobody_out(self):
        with ExitStack() as peers:
            for number in range(30):
                stranger = peers.enter_context(Peer(None))
                with suppress(OSError):
                    stranger.socket.sendall((b"", b"GET / HTTP/1.1\r\n\r\n", bytes(64))[number % 3])
            for header in ({"md5sum": "0" * 32}, {"service": "/none"}, {"callerid": "x" * 50_000}):
                peers.enter_context(Peer("/odd", **header))
            self.assert_moves_and_stops()

    def test_7_requests_that_are_no_requests_end_their_connection_alone(self):
        for raw in (struct.pack("<I", 0), struct.pack("<II", 4, 99), b"\xff" * 64):
            with suppress(OSError, AssertionError), Peer("/broken") as peer:
                peer.greet()
                peer.socket.sendall(raw)
                peer.socket.settimeout(1.0)
                peer.answer()
        self.assert_moves_and_stops()

    def test_8_junk_on_every_topic_moves_nothing(self):
        rng = random.Random(8)
        topics = {
            "joint_states": JointState,
            "robot/gripped": Bool,
            "robot/fault": String,
            "rst_control/heartbeat": Time,
            "session_log/recording": String,
            "rst_control/execute/goal": AssistActionGoal,
        }
        kinds = {name: junk(kind, rng) for name, kind in topics.items()}
        publishers = {name: rospy.Publisher(name, kinds[name], queue_size=10) for name in topics}
        wrong = rospy.Publisher("rst_control/stop", String, queue_size=1)  # of another type
        self.robot.wait(lambda: all(p.get_num_connections() for p in publishers.values()))
        before = self.robot.joints.position
        for _ in range(150):
            for name, publisher in publishers.items():
                publisher.publish(kinds[name]())
            wrong.publish("tense")
            rospy.sleep(0.01)
        self.assertNotIn(self.robot.state.state, ("moving", "stopping"))
        self.assertLess(self.robot.away(before), 1e-4)
        for publisher in (*publishers.values(), wrong):
            publisher.unregister()
        self.assert_loop_runs()

    def test_9_after_the_junk_it_moves_and_stops_as_ever(self):
        self.assert_moves_and_stops()

    def test_9_strangers_keep_nothing_moving_and_are_named(self):
        grip = rospy.Publisher("robot/gripped", Bool, queue_size=1)
        beat = rospy.Publisher("rst_control/heartbeat", Time, queue_size=1)
        self.robot.wait(lambda: grip.get_num_connections() and beat.get_num_connections())
        for _ in range(30):
            grip.publish(True)
            beat.publish(rospy.Time.now())
            rospy.sleep(0.05)
        self.assertFalse(self.robot.state.tissue_held)
        self.robot.wait(lambda: "/robot/gripped from /hostile_calls" in self.strangers)
        self.assertIn("/rst_control/heartbeat from /hostile_calls", self.strangers)
        for publisher in (grip, beat):
            publisher.unregister()
        self.robot.wait(lambda: "/hostile_calls" not in self.strangers)


if __name__ == "__main__":
    run_tests(HostileCalls, "hostile_calls")

#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The alarm node's wiring: what comes in by topic goes out as an alarm and as a marker."""

import unittest

import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from std_msgs.msg import Bool, Empty
from visualization_msgs.msg import Marker

from rst_control.msg import ControllerState, Event, ReasonCode
from support.waiting import wait_until
from tests.support.robot_client import run_tests
from voice_assist.msg import Alarm, Utterance
from voice_assist.text.phonetic_distance import can_pronounce

STOP = "stopped by voice"
OVER = "tension 2.50 N, allowed 2.40 N"


class Alarms(unittest.TestCase):
    """Each way in, one after the other."""

    @classmethod
    def setUpClass(cls):
        cls.alarm, cls.marker = Alarm(), Marker()
        cls.state = ControllerState(state="active", assistance_enabled=True)
        rospy.Subscriber("voice_assist/alarm", Alarm, lambda m: setattr(cls, "alarm", m))
        rospy.Subscriber("voice_assist/alarm_marker", Marker, lambda m: setattr(cls, "marker", m))
        cls.heard = Marker()
        rospy.Subscriber("voice_assist/heard_marker", Marker, lambda m: setattr(cls, "heard", m))
        cls.states = rospy.Publisher("rst_control/state", ControllerState, queue_size=2)
        cls.events = rospy.Publisher("rst_control/event", Event, queue_size=10)
        cls.said = rospy.Publisher("voice_assist/utterance", Utterance, queue_size=10)
        cls.health = rospy.Publisher("/diagnostics", DiagnosticArray, queue_size=10)
        cls.beat = rospy.Timer(rospy.Duration(0.02), cls.publish_state)
        for topic in (cls.states, cls.events, cls.said, cls.health):
            while topic.get_num_connections() == 0 and not rospy.is_shutdown():
                rospy.sleep(0.05)

    @classmethod
    def publish_state(cls, _):
        cls.state.header.stamp = rospy.Time.now()
        cls.states.publish(cls.state)

    def be(self, state, reason="", code="", held=False):
        self.state.state = state
        self.state.halt_reason, self.state.halt_reason_code = reason, code
        self.state.tissue_held = held

    def test_1_a_stop_stands_and_says_what_to_do(self):
        self.be("halted", STOP, ReasonCode.STOP_TOPIC)
        wait_until(lambda: self.alarm.kind == "stop")
        self.assertEqual((self.alarm.priority, self.alarm.cause), (Alarm.MEDIUM, STOP))
        self.assertIn("hey robot", self.alarm.next_step)
        wait_until(lambda: STOP in self.marker.text)

    def test_2_a_fault_comes_first_and_flashes(self):
        self.be("faulted", OVER, ReasonCode.OVER_TENSION, held=True)
        wait_until(lambda: self.alarm.kind == "fault")
        self.assertEqual(self.alarm.priority, Alarm.HIGH)
        wait_until(lambda: self.marker.color.a < 0.5)
        wait_until(lambda: self.marker.color.a > 0.9)

    def test_3_hey_robot_acknowledges_and_its_refusal_is_shown(self):
        self.events.publish(
            Event(
                kind="refused",
                command="hey robot",
                message="robot not connected",
                reason_code=ReasonCode.NOT_CONNECTED,
            )
        )
        wait_until(lambda: self.alarm.acknowledged and len(self.alarm.others) == 1)
        self.assertIn("robot not connected", self.alarm.others[0])

    def test_4_all_is_well_again(self):
        self.be("active")
        wait_until(lambda: self.alarm.kind == "")
        wait_until(lambda: self.marker.action == Marker.DELETE)

    def test_5_words_of_a_command_that_was_not_taken_are_shown(self):
        reason = "confidence 0.31, allowed: at least 0.50"
        said = Utterance(phrases=["tense"], wer=[0.0], nearest_command="tense", reason=reason)
        said.transcript = "tense"
        said.reason_code = Utterance.UNSURE
        self.said.publish(said)
        wait_until(lambda: self.alarm.kind == "refusal")
        self.assertEqual(self.alarm.next_step, "Say it again, clearly.")
        wait_until(lambda: self.heard.text == f'heard "tense"\nnot taken: {reason}')
        self.assertEqual(self.heard.type, Marker.TEXT_VIEW_FACING)
        self.assertGreater(self.heard.lifetime.to_sec(), 1.0)
        wait_until(lambda: self.alarm.kind == "")
        other = Utterance(phrases=["tense"], wer=[1.0], nearest_command="tense", reason="WER 1.0")
        other.reason_code = Utterance.NO_COMMAND
        self.said.publish(other)
        rospy.sleep(0.5)
        self.assertEqual(self.alarm.kind, "")

    def test_6_a_deaf_microphone_is_reported_by_diagnostics(self):
        status = DiagnosticStatus(level=DiagnosticStatus.ERROR, name="voice_assist: voice")
        status.message = "default microphone: not found"
        self.health.publish(DiagnosticArray(status=[status]))
        wait_until(lambda: self.alarm.kind == "fault")
        self.assertIn("microphone", self.alarm.cause)

    def test_7_what_was_taken_is_said_and_announced_and_a_stop_silences(self):
        if not can_pronounce():
            raise unittest.SkipTest("espeak-ng is not installed")
        self.be("active")
        well = DiagnosticStatus(level=DiagnosticStatus.OK, name="voice_assist: voice")
        voice = DiagnosticArray(status=[well])  # a fault would come before what is said
        beat = rospy.Timer(rospy.Duration(0.5), lambda _: self.health.publish(voice))
        spoke, times = [], []
        speaking = rospy.Subscriber("voice_assist/speaking", Bool, lambda m: spoke.append(m.data))
        stop = rospy.Publisher("rst_control/stop", Empty, queue_size=1)
        wait_until(lambda: speaking.get_num_connections() and stop.get_num_connections())
        wait_until(lambda: self.accept(times) or len(spoke) >= 2)
        self.assertEqual(spoke[:2], [True, False])
        wait_until(lambda: len(spoke) % 2 == 0)
        self.be("moving")
        rospy.sleep(1.0)
        self.assert_unsaid("pull less", spoke)
        self.be("active")
        stop.publish(Empty())
        rospy.sleep(1.0)  # less than quiet_after_stop
        self.assert_unsaid("release", spoke)
        beat.shutdown()

    def assert_unsaid(self, command, spoke):
        """A command that is accepted is shown, and nothing is said of it."""
        count = len(spoke)
        self.events.publish(Event(kind="accepted", command=command, message="x"))
        wait_until(lambda: command in self.alarm.cause + "".join(self.alarm.others))
        rospy.sleep(1.0)
        self.assertEqual(len(spoke), count)

    def accept(self, times):
        """Another command is accepted, at most twice a second; false, to be waited on."""
        if not times or rospy.Time.now() - times[-1] > rospy.Duration(0.5):
            times.append(rospy.Time.now())
            self.events.publish(Event(kind="accepted", command="pull more", message="x"))
        return False


if __name__ == "__main__":
    run_tests(Alarms, "alarms_test")

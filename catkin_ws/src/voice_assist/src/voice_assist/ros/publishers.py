# SPDX-License-Identifier: BSD-3-Clause
"""Everything that the voice node publishes, except diagnostics."""

from __future__ import annotations

import time

import rospy
from std_msgs.msg import Empty, String, Time

from voice_assist.msg import AudioChunk
from voice_assist.msg import Mode as ModeMessage
from voice_assist.msg import Utterance as UtteranceMessage
from voice_assist.ros import messages
from voice_assist.side_inputs import SideInput, to_text
from voice_assist.types import Frame, Match, Mode, Partial, UtteranceDecision

# [s] without heartbeats after a stop; more than the controller's watchdogs.voice_heartbeat_age.
# The missing heartbeat stops the robot where the stop itself is lost or late.
QUIET = 1.0


class Publishers:
    """The topics, by relative names."""

    def __init__(self) -> None:
        """Announce them."""
        advertise = rospy.Publisher
        self._audio = advertise("voice_assist/audio", AudioChunk, queue_size=100)
        self._partial = advertise("voice_assist/partial", String, queue_size=20)
        self._utterance = advertise("voice_assist/utterance", UtteranceMessage, queue_size=100)
        self._side_inputs = advertise("voice_assist/circumstances", String, queue_size=1000)
        self._say = advertise("voice_assist/say", String, queue_size=20)
        self._mode = advertise("voice_assist/mode", ModeMessage, queue_size=10, latch=True)
        self._stop = advertise("rst_control/stop", Empty, queue_size=10)
        self._heartbeat = advertise("rst_control/heartbeat", Time, queue_size=1)
        self._quiet_until = float("-inf")  # [s] steady clock

    def audio(self, frame: Frame) -> None:
        """What is heard, unmodified."""
        self._audio.publish(messages.audio_chunk(frame))

    def side_input(self, side_input: SideInput) -> None:
        """An input of hearing other than the sound, for the recording."""
        self._side_inputs.publish(String(data=to_text(side_input)))

    def partial(self, partial: Partial) -> None:
        """What has been heard so far."""
        self._partial.publish(String(data=partial.text))

    def utterance(self, decision: UtteranceDecision, now: float) -> None:
        """What was decided, at ROS time `now` [s]; the log has it in words."""
        self._utterance.publish(messages.utterance(decision, now))
        outcome, text = decision.outcome, decision.hypothesis.text
        if isinstance(outcome, Match):
            by = "" if decision.decided_by == "recognizer" else f", by the {decision.decided_by}"
            rospy.loginfo("heard %r: %s (%.2f%s)", text, outcome.command, decision.confidence, by)
        else:
            named = outcome.nearest_command
            nearest = f", nearest {named!r}" if named else ""
            rospy.loginfo("heard %r: no command, %s%s", text, outcome.rejection.words, nearest)

    def mode(self, mode: Mode, reason: str, now: float) -> None:
        """The voice mode, latched."""
        self._mode.publish(messages.mode_message(mode, reason, now))

    def reply(self, text: str) -> None:
        """What a loudspeaker may say of the controller's reply."""
        self._say.publish(String(data=text))

    def stop(self) -> None:
        """Stop the robot, without waiting for an answer."""
        self._quiet_until = time.monotonic() + QUIET
        self._stop.publish(Empty())

    def heartbeat(self, now: float) -> None:
        """A spoken stop would be heard now; says nothing for a while after one."""
        if time.monotonic() >= self._quiet_until:
            self._heartbeat.publish(Time(data=rospy.Time.from_sec(now)))

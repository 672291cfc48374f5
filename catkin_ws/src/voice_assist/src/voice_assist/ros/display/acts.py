# SPDX-License-Identifier: BSD-3-Clause
"""What a person does on the page, by the topics and services that a person by hand uses, too."""

from __future__ import annotations

from typing import Any

import rospy
from geometry_msgs.msg import Point, Vector3
from std_msgs.msg import Empty

from rst_control.srv import Command, SetGraspPoint
from typed_config.ros.service_calls import Reply, call_service
from voice_assist.display.acts import Outcome
from voice_assist.display.picking import NotOnTissueError
from voice_assist.display.theatre import Theatre
from voice_assist.ros.display.endoscope import Endoscope
from voice_assist.ros.microphone_service import SERVICE as MICROPHONE
from voice_assist.ros.question_service import SERVICE as ANSWER
from voice_assist.ros.robot.command_client import SERVICE
from voice_assist.srv import AnswerQuestion, SetMicrophone

GRASP_POINT = "rst_control/set_grasp_point"
STOP_TOPIC = "rst_control/stop"
WITHIN = 2.5  # [s] for a service to answer; the page waits longer
CHOICE_WITHIN = 8.5  # [s] the same of a microphone, for which the voice node may have to search
MAY_COME = "; it may still be taken"  # a request that was sent and not answered


class RosActs:
    """Acts on the system under this node's name, by which the controller distinguishes callers.

    Args:
        theatre: Learns what was answered.
        endoscope: Turns a click into a point.
    """

    def __init__(self, theatre: Theatre, endoscope: Endoscope) -> None:
        self._theatre, self._endoscope = theatre, endoscope
        self._stop = rospy.Publisher(STOP_TOPIC, Empty, queue_size=10)

    def send_stop(self) -> None:
        """Publish the stop; it waits for nobody."""
        self._stop.publish(Empty())

    def stop(self) -> Outcome:
        """Ask the controller by its service, too, and say what it answers."""
        reply = _call(SERVICE, Command, "stop")
        if (response := reply.response) is None:
            return _unanswered(reply, "the controller does not answer")
        return Outcome(bool(response.accepted), response.message)

    def choose_microphone(self, name: str) -> Outcome:
        """Hear by another microphone."""
        reply = _call(MICROPHONE, SetMicrophone, name, within=CHOICE_WITHIN)
        if (response := reply.response) is None:
            is_there = reply.may_take_effect
            missing = "no voice node listens to a microphone"
            return _unanswered(reply, "the voice node does not answer" if is_there else missing)
        words = response.message or f"the microphone is {name!r} now"
        return Outcome(bool(response.success), words)

    def answer(self, command: str, is_yes: bool) -> Outcome:
        """Answer what the voice node asked."""
        reply = _call(ANSWER, AnswerQuestion, command, is_yes)
        if (response := reply.response) is None:
            return _unanswered(reply, "the voice node does not answer")
        if response.success:
            self._theatre.end_question()
        return Outcome(bool(response.success), response.message)

    def set_grasp_point(self, x: float, y: float, stamp: float) -> Outcome:
        """Take the tissue where a click meets it, if the controller finds that it can."""
        try:
            point = self._endoscope.point(x, y, stamp)
        except NotOnTissueError as error:
            return Outcome(False, str(error))
        reply = _call(GRASP_POINT, SetGraspPoint, Point(*point), Vector3(), "")
        if (response := reply.response) is None:
            return _unanswered(reply, "the controller does not answer")
        return Outcome(bool(response.accepted), response.message)


def _call(name: str, kind: Any, *words: Any, within: float | None = None) -> Reply:
    """What came of a call of a service; what is not sent in time is not sent later.

    Args:
        name: Of the service.
        kind: Its class.
        words: Of the request.
        within: Longest wait for the answer [s]; None: `WITHIN`, as for the service to be there.
    """
    limit = WITHIN if within is None else within
    return call_service(name, kind, *words, within=limit, appears=WITHIN)


def _unanswered(reply: Reply, words: str) -> Outcome:
    """That nothing came back; a request that went out may be taken all the same."""
    return Outcome(False, words + (MAY_COME if reply.may_take_effect else ""))

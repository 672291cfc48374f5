# SPDX-License-Identifier: BSD-3-Clause
"""Who does not answer is named with the time that was allowed."""

import threading
from types import SimpleNamespace

import rospy

from voice_assist.ros import question_service
from voice_assist.ros.question_service import QuestionService
from voice_assist.ros.robot.command_client import CommandClient


def test_a_recognition_that_takes_no_answer_is_named(monkeypatch):
    monkeypatch.setattr(question_service, "WITHIN", 0.05)
    reply = QuestionService()._serve(SimpleNamespace(command="tense", is_yes=True))
    assert (reply.success, reply.message) == (False, "recognition does not answer within 0.05 s")


def test_a_controller_that_does_not_answer_is_named(monkeypatch):
    def fail(request):
        raise rospy.ServiceException("nobody there")

    fail.transport, fail.close = None, lambda: None
    is_over, answers, come = threading.Event(), [], threading.Event()
    monkeypatch.setattr(rospy, "is_shutdown", is_over.is_set)
    monkeypatch.setattr(rospy, "ServiceProxy", lambda *_, **__: fail)

    def take(answered):
        answers.append(answered)
        come.set()
        is_over.wait(10.0)

    client = CommandClient(0.5, take)
    client.call("tense", may_repeat=False)
    assert come.wait(10.0)
    is_over.set()
    for thread in threading.enumerate():
        if thread.name == "command client":  # before rospy is the true one again
            thread.join(10.0)
    words = "the robot's controller is missing or does not answer within 0.5 s"
    assert [(a.command, a.is_accepted, a.message) for a in answers] == [("tense", False, words)]

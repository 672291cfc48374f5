# SPDX-License-Identifier: BSD-3-Clause
"""What the services share: who may set something up, and the wait for an answer."""

from __future__ import annotations

import time
from concurrent.futures import Future
from concurrent.futures import TimeoutError as NoReply

import genpy
import rospy

from rst_control.admission.callers import CallLimiter
from rst_control.execution.orders import Reply
from rst_control.ros.controller.messages import caller_of
from rst_control.types import Reason

REPLY_TIME = 2.0  # [s] within which every call is answered, if only by NO_ANSWER
UNANSWERED = (
    f"the controller gave no answer within {REPLY_TIME:g} s; nothing is changed or moved by it"
)


class SetUpCallers:
    """Who may call the services that set something up; turns others away.

    Args:
        limiter: Knows who may set up, and how often.
    """

    def __init__(self, limiter: CallLimiter) -> None:
        self._limiter = limiter

    def refusal(self, request: genpy.Message) -> Reply | None:
        """Refuse a call of somebody who may not call, or calls too often; None: take it."""
        admission = self._limiter.admit(caller_of(request))
        refusal = admission.refusal
        if refusal is not None and admission.is_news:
            rospy.logwarn("refused: %s", refusal.words)
        time.sleep(admission.pause)
        return Reply.refused(refusal) if refusal is not None else None


def answer_of(answer: Future[Reply]) -> Reply:
    """What the controller says; without an answer in time the question is withdrawn."""
    try:
        return answer.result(REPLY_TIME)
    except NoReply:
        if answer.cancel():
            return Reply(False, UNANSWERED, Reason.NO_ANSWER)
        return answer.result(REPLY_TIME)  # it is being answered at this moment

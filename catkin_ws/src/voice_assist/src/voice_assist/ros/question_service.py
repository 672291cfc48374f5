# SPDX-License-Identifier: BSD-3-Clause
"""The service by which a person answers, by hand, what the voice node asked."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Future
from dataclasses import dataclass, field
from queue import Empty, Queue

import rospy

from voice_assist.srv import AnswerQuestion, AnswerQuestionRequest, AnswerQuestionResponse

SERVICE = "voice_assist/answer"
WITHIN = 1.0  # [s] for recognition to take it, between two frames


@dataclass(frozen=True, eq=False)
class HandAnswer:
    """An answer that waits for recognition; `stood` gets whether it was asked for."""

    command: str
    is_yes: bool
    stood: Future[bool] = field(default_factory=Future)


class QuestionService:
    """Hands answers from the service's threads to recognition's."""

    def __init__(self) -> None:
        self._given: Queue[HandAnswer] = Queue()
        self._service: rospy.Service | None = None

    def start(self) -> None:
        """Begin to serve."""
        self._service = rospy.Service(SERVICE, AnswerQuestion, self._serve)

    def take(self) -> Iterator[HandAnswer]:
        """Those that came; one whose caller waits no longer is left out."""
        while True:
            try:
                given = self._given.get_nowait()
            except Empty:
                return
            if given.stood.set_running_or_notify_cancel():
                yield given

    def _serve(self, request: AnswerQuestionRequest) -> AnswerQuestionResponse:
        given = HandAnswer(request.command, request.is_yes)
        self._given.put(given)
        try:
            has_stood = given.stood.result(WITHIN)
        except TimeoutError:
            if given.stood.cancel():
                words = f"recognition does not answer within {WITHIN:g} s"
                return AnswerQuestionResponse(False, words)
            has_stood = given.stood.result(WITHIN)
        if not has_stood:
            return AnswerQuestionResponse(False, f"{request.command!r} is not asked for any more")
        done = "sent to the robot" if request.is_yes else "dropped"
        return AnswerQuestionResponse(True, f"{request.command}: {done}")

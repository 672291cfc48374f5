# SPDX-License-Identifier: BSD-3-Clause
"""Commands in words: the string service, and the topic on which anyone may stop the robot."""

from __future__ import annotations

import time

import genpy
import rospy
from std_msgs.msg import Empty, Time

from rst_control.admission.callers import CallLimiter
from rst_control.admission.command_queue import CommandQueue
from rst_control.commands.parser import MAX_LENGTH, is_stop, read_command, unknown
from rst_control.commands.spec import Role
from rst_control.execution.executor import Executor
from rst_control.ros.controller.messages import caller_of, code_of
from rst_control.ros.controller.services.admission import answer_of
from rst_control.ros.rospy_patches.message_framing import announced
from rst_control.srv import Command, CommandRequest, CommandResponse
from rst_control.supervision.heartbeat import Heartbeat
from rst_control.types import Cause, Reason
from typed_config.ros.known_publishers import KnownPublishers

_HEAD = 4  # bytes of the length before the words
COMMAND = "rst_control/command"  # name of the service


class WordsRequest(CommandRequest):
    """A request of which no more was kept than a command may be long."""

    length = 0  # [bytes] of all that was said; 0: the words are whole

    def deserialize(self, buff: bytes) -> WordsRequest:
        """Read a request that is as long as it says: the generated class takes what there is.

        Raises:
            genpy.DeserializationError: It is not, and no stop either.
        """
        super().deserialize(buff)
        said = _HEAD + announced(buff)
        if len(buff) != said and not is_stop(self.command):
            raise genpy.DeserializationError(f"{said} bytes were announced")
        return self

    @classmethod
    def cut(cls, beginning: bytes, size: int) -> WordsRequest:
        """The beginning of a request too long to be read; `size` [bytes] is that of all of it."""
        request = cls()
        request.command = beginning[_HEAD : _HEAD + 2 * MAX_LENGTH].decode("utf-8", "replace")
        request.length = size - _HEAD
        return request


class WordsCommand(Command):
    """rst_control/Command, taken in without its tail where that is too long."""

    _request_class = WordsRequest


class CommandService:
    """Serves `rst_control/command`; listens to `rst_control/stop` and `rst_control/heartbeat`.

    Args:
        commands: Takes the commands.
        executor: Takes stops and heartbeats.
        limiter: Knows who may command, and how often.
        spoken_by: Name of the node whose commands count as spoken.
        heartbeat_age: Age of the last heartbeat up to which that node counts as alive [s].
        known: Makes the subscriber to the heartbeat, which is believed of that node alone.
    """

    def __init__(
        self,
        commands: CommandQueue,
        executor: Executor,
        limiter: CallLimiter,
        spoken_by: str,
        heartbeat_age: float,
        known: KnownPublishers,
    ) -> None:
        self._commands, self._executor, self._limiter = commands, executor, limiter
        self._spoken_by, self._heartbeat = spoken_by, Heartbeat(heartbeat_age)
        # Of what piles up on one connection the newest counts; a flood is not queued.
        newest = {"tcp_nodelay": True, "queue_size": 1}
        self._stop = rospy.Subscriber("rst_control/stop", Empty, self._on_stop, **newest)
        self.heartbeats = known.subscribe(
            "rst_control/heartbeat", Time, self._on_heartbeat, (spoken_by,), **newest
        )
        self._service: rospy.Service | None = None

    def start(self) -> None:
        """Begin to take commands."""
        self._service = rospy.Service(COMMAND, WordsCommand, self._on_command)

    def _on_command(self, request: WordsRequest) -> CommandResponse:
        caller = caller_of(request)
        admission = self._limiter.admit(caller, is_stop(request.command))
        refusal = admission.refusal
        if refusal is not None and not admission.is_news:
            response = CommandResponse(False, refusal.words, code_of(refusal))
        else:
            if request.length and refusal is None:
                refusal = unknown(request.command, request.length)
            response = self._ask(request.command, caller, refusal)
        time.sleep(admission.pause)  # after a stop, too: it has been carried out
        return response

    def _ask(self, words: str, caller: str, refusal: Cause | None) -> CommandResponse:
        is_spoken = caller == self._spoken_by
        if is_spoken and refusal is None:
            refusal = self._silence(words)
        owner = caller if is_spoken else ""
        pending = self._commands.take(words, caller, is_spoken, not is_spoken, refusal, owner)
        reply = answer_of(pending.reply)
        return CommandResponse(reply.accepted, reply.message, code_of(reply.reason))

    def _silence(self, words: str) -> Cause | None:
        """Whether the voice node's heartbeat forbids a spoken command; only motions need it."""
        command = read_command(words)
        if command is not None and command.role is not Role.MOTION:
            return None
        return self._heartbeat.objection(time.monotonic())

    def _on_stop(self, message: Empty) -> None:
        received, sender = time.monotonic(), caller_of(message)
        who = "voice" if sender == self._spoken_by else sender
        self._executor.stop(Cause(Reason.STOP_TOPIC, f"stopped by {who}"), received, sender)

    def _on_heartbeat(self, message: Time) -> None:
        sent, now = message.data.to_sec(), time.monotonic()
        self._executor.heartbeat(self._heartbeat.beat(sent, rospy.get_time(), now))

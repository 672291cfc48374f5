# SPDX-License-Identifier: BSD-3-Clause
"""The voice of the soak: transcripts by the real mapper and dialogue to the queue of commands.

Sound and recognition are left out; `bench/voice/soak` measures those.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

from rst_control.admission.command_queue import CommandQueue, PendingCommand
from rst_control.execution.executor import Executor
from rst_control.types import Cause, Reason
from voice_assist.config import CommandsConfig
from voice_assist.intent.dialogue import AT_START, Answered, CommandRecognized, DialogueState, step
from voice_assist.intent.mapper import Mapper
from voice_assist.types import Call, Halt, Match, Mode

NODE = "/voice_assist"


@dataclass(frozen=True)
class SoakSpeech:
    """What a transcript came to."""

    command: str  # that was taken; empty: none
    has_acted: bool


class SoakVoice:
    """Hears transcripts; calls one command after the other, as `command_client` does.

    Args:
        commands: Settings.
        queue: Takes the commands.
        executor: Takes the stops.
    """

    def __init__(self, commands: CommandsConfig, queue: CommandQueue, executor: Executor) -> None:
        self._commands, self._mapper = commands, Mapper(commands)
        self._queue, self._executor = queue, executor
        self.state: DialogueState = AT_START
        self.is_alive = True  # its heartbeat goes on
        self._calls: deque[str] = deque()
        self._pending: PendingCommand | None = None

    def hear(self, transcript: str) -> SoakSpeech:
        """One utterance."""
        outcome = self._mapper(transcript)
        if not isinstance(outcome, Match):
            return SoakSpeech("", has_acted=False)
        done = step(self.state, CommandRecognized(self._commands.get(outcome.command)))
        self.state = done.state
        for action in done.actions:
            if isinstance(action, Halt):
                self._executor.stop(Cause(Reason.STOP_TOPIC, "stopped by voice"))
                self._calls.clear()
            elif isinstance(action, Call):
                self._calls.append(action.command)
        return SoakSpeech(outcome.command, bool(done.actions))

    def call(self) -> str:
        """Give the next command where the last one was answered; which one, or an empty string."""
        if self._pending is not None:
            if not self._pending.reply.done():
                return ""
            self._take_answer(self._pending)
        if not self._calls:
            return ""
        words = self._calls.popleft()
        self._pending = self._queue.take(words, NODE, self.is_alive, is_by_hand=False)
        return words

    def restart(self) -> None:
        """As after its process was started anew."""
        self.state, self.is_alive = AT_START, True
        self._calls.clear()
        self._pending = None

    @property
    def is_active(self) -> bool:
        """Spoken motions count."""
        return self.state.mode is Mode.ACTIVE

    def _take_answer(self, pending: PendingCommand) -> None:
        reply, self._pending = pending.reply.result(0), None
        answer = Answered(pending.words, reply.accepted, reply.message)
        self.state = step(self.state, answer).state

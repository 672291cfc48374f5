# SPDX-License-Identifier: BSD-3-Clause
"""Asks once for a motion that is nearly sure; "yes" does it, and whatever else is said drops it."""

from __future__ import annotations

from voice_assist.config.voice import AskConfig
from voice_assist.text.normalize import normalize


class Question:
    """The question that stands, if there is one. All times are of the stream's clock [s]."""

    def __init__(self, config: AskConfig) -> None:
        """Nothing is asked."""
        self._config = config
        self.close()

    def close(self) -> None:
        """Nothing is asked any more."""
        self._command, self._until = "", float("-inf")

    def is_open(self, time: float) -> bool:
        """Whether what begins to be said at a time is the answer to a question."""
        return time <= self._until

    def ask(self, command: str, time: float) -> None:
        """Ask for a command."""
        self._command, self._until = command, time + self._config.answer_within

    def is_about(self, command: str, time: float) -> bool:
        """Whether a command is asked for at a time."""
        return command == self._command and self.is_open(time)

    def confirmed(self, transcript: str, speech_start: float) -> str:
        """The command that is asked for, if this confirms it; empty: it does not.

        Args:
            transcript: Of a whole utterance.
            speech_start: When it began.
        """
        is_yes = normalize(transcript) == normalize(self._config.answer)
        return self._command if is_yes and self.is_open(speech_start) else ""

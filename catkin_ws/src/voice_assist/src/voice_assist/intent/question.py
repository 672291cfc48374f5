# SPDX-License-Identifier: BSD-3-Clause
"""Asks once for a motion; "yes", or the motion again, does it, and all else drops it.

The robot's own voice, which may speak of it, is no answer.
"""

from __future__ import annotations

from voice_assist.config.voice import AskConfig
from voice_assist.text.normalize import normalize
from voice_assist.types import Match, NoMatch, RejectionReason


class Question:
    """The question that stands, if there is one. All times are of the stream's clock [s]."""

    def __init__(self, config: AskConfig, is_repeated: bool = False) -> None:
        """Nothing is asked.

        Args:
            config: How it is answered.
            is_repeated: The motion again is an answer.
        """
        self._config, self.is_repeated = config, is_repeated
        self.close()

    def close(self) -> None:
        """Nothing is asked any more."""
        self._command, self._since, self._until = "", float("inf"), float("-inf")
        self._has_waited = False  # for the robot's own voice

    def is_open(self, time: float) -> bool:
        """Whether what begins to be said at a time is the answer to a question."""
        return self._since <= time <= self._until

    def ask(self, command: str, said: float, time: float) -> None:
        """Ask for a command.

        Args:
            command: Its phrase.
            said: When it had been said; what began before is no answer.
            time: Now.
        """
        self._command, self._since = command, said
        self._until = time + self._config.answer_within

    def put(self, time: float) -> None:
        """Let its time begin when people learn of it, where recognition took long to ask."""
        self._until = max(self._until, time + self._config.answer_within)

    def wait(self, spoken: float, audible: float) -> None:
        """Let its time begin anew, once, where the robot itself spoke while it stood.

        Args:
            spoken: When the robot had spoken.
            audible: Until when its voice may be heard.
        """
        if self.is_open(spoken) and not self._has_waited:
            self._until, self._has_waited = audible + self._config.answer_within, True

    def is_about(self, command: str, time: float) -> bool:
        """Whether a command is asked for at a time."""
        return command == self._command and self.is_open(time)

    def said_again(self, outcome: Match | NoMatch, speech_start: float) -> Match | None:
        """The motion that is asked for, if it would be asked for again; None: it is not.

        Args:
            outcome: Of an utterance.
            speech_start: When that began.
        """
        if not self.is_repeated or isinstance(outcome, Match):
            return None
        would_ask = outcome.rejection.reason is RejectionReason.NEARLY_SURE
        command = outcome.nearest_command
        is_it = would_ask and self.is_about(command, speech_start)
        return Match(command, outcome.wer) if is_it else None

    def confirmed(self, transcript: str, speech_start: float) -> str:
        """The command that is asked for, if this confirms it; empty: it does not.

        Args:
            transcript: Of a whole utterance.
            speech_start: When it began.
        """
        is_yes = normalize(transcript) == normalize(self._config.answer)
        return self._command if is_yes and self.is_open(speech_start) else ""

# SPDX-License-Identifier: BSD-3-Clause
"""Sets what was meant to be said beside what it was taken for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from session_log.config import ReportConfig
from session_log.report.session.session_data import IntendedPhrase, RecordedUtterance, SessionData

NO_COMMAND = "no command"  # meant: words that are none
NOT_SAID = "not said"  # nothing was meant to be said, or what was said is accounted for
NOTHING = "nothing heard"  # taken: no utterance came of it
OTHER = "another phrase"  # taken: an utterance that was no command


@dataclass(frozen=True)
class PhraseTrial:
    """One phrase that was played or prompted, and what became of it."""

    time: float  # [s] when it began to sound
    intended: str  # a command, NO_COMMAND or NOT_SAID
    taken: str  # a command, NOTHING or OTHER
    transcript: str

    @property
    def is_correct(self) -> bool:
        """Whether it was taken as it was meant."""
        return is_correct(self.intended, self.taken)


def is_correct(intended: str, taken: str) -> bool:
    """Whether the command meant was taken, or none where none was meant."""
    return taken in (NOTHING, OTHER) if intended in (NO_COMMAND, NOT_SAID) else taken == intended


def trials(data: SessionData, config: ReportConfig) -> list[PhraseTrial]:
    """Judge every intended phrase of a session; empty if it does not know what was meant.

    An utterance belongs to the phrase that last began to sound before it, within
    `intended_window`. The first command taken counts, because the robot acts on it. A command
    that belongs to no phrase, or a different one that follows for the same phrase, is a trial
    of its own, `NOT_SAID`.
    """
    if not data.intended:
        return []
    intended = sorted(data.intended, key=lambda i: i.time)
    known = {*data.phrases, *(entry.command for entry in config.paper.latency)}
    mine: list[list[RecordedUtterance]] = [[] for _ in intended]
    found = []
    for heard in sorted(data.heard, key=lambda h: h.decision):
        owner = _owner(heard, intended, config)
        if owner is not None:
            mine[owner].append(heard)
        elif heard.command:
            found.append(PhraseTrial(heard.speech_start, NOT_SAID, heard.command, heard.transcript))
    for phrase, said in zip(intended, mine, strict=True):
        # without any utterance, the commands of the session's language are unknown
        is_known = phrase.phrase in known or (phrase.phrase and not data.phrases)
        found += _judge(phrase, phrase.phrase if is_known else NO_COMMAND, said)
    return sorted(found, key=lambda trial: trial.time)


def _owner(
    heard: RecordedUtterance, intended: Sequence[IntendedPhrase], config: ReportConfig
) -> int | None:
    began = [
        i for i, p in enumerate(intended) if p.time <= heard.speech_start + config.intended_slack
    ]
    if not began or heard.speech_start - intended[began[-1]].time > config.intended_window:
        return None
    return began[-1]


def _judge(
    phrase: IntendedPhrase, meant: str, said: Sequence[RecordedUtterance]
) -> list[PhraseTrial]:
    words = " / ".join(h.transcript for h in said if h.transcript)
    taken = [h for h in said if h.command]
    if not taken:
        return [PhraseTrial(phrase.time, meant, OTHER if words else NOTHING, words)]
    first = taken[0].command
    extra = [h for h in taken[1:] if h.command not in (first, meant)]
    return [
        PhraseTrial(phrase.time, meant, first, words),
        *(PhraseTrial(h.speech_start, NOT_SAID, h.command, h.transcript) for h in extra),
    ]

# SPDX-License-Identifier: BSD-3-Clause
"""The guided script: what the person shall say next, until the profile has all of it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass

from voice_assist.config.enrolment import EnrolmentConfig
from voice_assist.enrolment.takes.checks import Checked
from voice_assist.profile.manifest import COMMAND, ROOM, TALK, Take
from voice_assist.profile.profile import VoiceProfile, now
from voice_assist.types import RATE, Samples

GOOD, UNLIKE = "good", "kept though unlike the base's idea of it, as it was so again"
MICROPHONE = "microphone"

Check = Callable[[str, str, Samples], Checked]  # kind, phrase and sound of a take


@dataclass(frozen=True)
class EnrolmentStep:
    """One thing to record."""

    kind: str  # COMMAND, TALK or ROOM
    phrase: str  # to say; empty where it is no command
    seconds: float  # [s] to record
    number: int  # of this one among those of its kind, from 1
    total: int


class EnrolmentScript:
    """Goes through the script; it keeps no state beside the profile, so it can go on any time."""

    def __init__(
        self, profile: VoiceProfile, config: EnrolmentConfig, phrases: tuple[str, ...], check: Check
    ) -> None:
        """Go on where the profile is.

        Args:
            profile: That takes are added to.
            config: How many takes of what.
            phrases: Of all commands, in the order in which they are asked for.
            check: Judges a take.
        """
        self.profile, self._config, self._phrases = profile, config, phrases
        self._check = check
        self._unlike: Counter[str] = Counter()  # takes unlike the base's expectation, by phrase
        self.kept = 0  # takes added to the profile

    def next(self) -> EnrolmentStep | None:
        """What to record now; None: all is there.

        The room comes first, then the commands in turns, so that no phrase is said many times in a
        row in one tone, then the talk.
        """
        takes = self.profile.manifest.takes
        if not any(take.kind == ROOM for take in takes):
            return EnrolmentStep(ROOM, "", self._config.room, 1, 1)
        said = Counter(take.phrase for take in takes if take.kind == COMMAND)
        fewest = min(said[phrase] for phrase in self._phrases)
        if fewest < self._config.repetitions:
            phrase = next(p for p in self._phrases if said[p] == fewest)
            done = sum(min(said[p], self._config.repetitions) for p in self._phrases)
            all_of_them = self._config.repetitions * len(self._phrases)
            return EnrolmentStep(COMMAND, phrase, self._config.take, done + 1, all_of_them)
        return self._talk()

    def offer(self, step: EnrolmentStep, samples: Samples, source: str = MICROPHONE) -> Checked:
        """Check a take, and keep it if it is good.

        A take that is only unlike what the base expects is kept when the phrase was so before: then
        that is how this person says it. Another command is never kept.

        Args:
            step: What it is of.
            samples: float32 in [-1, 1], 16 kHz. Shape (n,).
            source: Where it comes from.

        Raises:
            VoiceProfileError: It cannot be written.
        """
        checked = self._check(step.kind, step.phrase, samples)
        verdict = GOOD
        if checked.is_unlike:
            self._unlike[step.phrase] += 1
            verdict = UNLIKE if self._unlike[step.phrase] > 1 else ""
        elif not checked.is_good:
            verdict = ""
        if verdict:
            self.profile.add_take(samples, _take(step, samples, checked, source, verdict))
            self.kept += 1
        return checked

    def take_over(self, kind: str, phrase: str, samples: Samples, source: str) -> Checked | None:
        """Offer a recording that exists; None: one of that name and length was offered and kept.

        Args:
            kind: COMMAND, TALK or ROOM.
            phrase: That is said in it, for COMMAND.
            samples: float32 in [-1, 1], 16 kHz. Shape (n,).
            source: Its name.

        Raises:
            VoiceProfileError: It cannot be written.
        """
        if self._has(samples, source):
            return None
        step = EnrolmentStep(kind, phrase, len(samples) / RATE, 1, 1)
        return self.offer(step, samples, source)

    def _has(self, samples: Samples, source: str) -> bool:
        length = len(samples) / RATE
        return any(
            take.source == source and abs(take.seconds - length) < 1.0 / RATE
            for take in self.profile.manifest.takes
        )

    def _talk(self) -> EnrolmentStep | None:
        there = [t.seconds for t in self.profile.manifest.takes if t.kind == TALK]
        missing = self._config.talk - sum(there)
        if missing <= 0.0:
            return None
        piece = self._config.talk_piece
        left = -(-missing // piece)
        return EnrolmentStep(TALK, "", piece, len(there) + 1, len(there) + int(left))


def _take(
    step: EnrolmentStep, samples: Samples, checked: Checked, source: str, verdict: str
) -> Take:
    """All that is known of a take but its file and check sum, which come when it is written."""
    return Take(
        file="takes/0000.wav",
        sha256="0" * 64,
        kind=step.kind,
        phrase=step.phrase,
        time=now(),
        source=source,
        seconds=len(samples) / RATE,
        level_db=checked.level_db,
        snr_db=checked.snr_db,
        heard=checked.heard,
        verdict=verdict,
    )

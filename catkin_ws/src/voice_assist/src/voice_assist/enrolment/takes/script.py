# SPDX-License-Identifier: BSD-3-Clause
"""The guided script: what the person shall say next, until the profile has all of it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass

from voice_assist.config.enrolment import EnrolmentConfig
from voice_assist.enrolment.takes.checks import Checked
from voice_assist.profile.manifest import COMMAND, ROOM, TALK, Take
from voice_assist.profile.profile import VoiceProfile, VoiceProfileError, now, take_digest
from voice_assist.recognizer.vocabulary import CHARACTERS
from voice_assist.text.normalize import normalize
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


@dataclass(frozen=True, eq=False)
class RecordedTake:
    """A recording of which it is known what was said."""

    name: str  # of the file, or of session and utterance
    kind: str  # COMMAND, TALK or ROOM
    phrase: str  # that is said in it; empty where it is no command
    samples: Samples  # (n,), float32 in [-1, 1], 16 kHz

    @property
    def seconds(self) -> float:
        """Its length [s]."""
        return len(self.samples) / RATE


class EnrolmentScript:
    """Goes through the script; its place in it is that of the profile, so it can go on any time."""

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
        return checked

    def take_over(
        self, takes: Iterable[RecordedTake], on_checked: Callable[[str, Checked], None]
    ) -> int:
        """Offer recordings that exist; one whose sound is on file already is left out.

        Args:
            takes: In their order.
            on_checked: Called with the name and the check of each that is offered.

        Returns:
            How many were kept.

        Raises:
            VoiceProfileError: One cannot be written.
        """
        before = len(self.profile.manifest.takes)
        for take in takes:
            if not self._has(take):
                step = EnrolmentStep(take.kind, take.phrase, take.seconds, 1, 1)
                on_checked(take.name, self.offer(step, take.samples, take.name))
        return len(self.profile.manifest.takes) - before

    def _has(self, recorded: RecordedTake) -> bool:
        digest = take_digest(recorded.samples)
        return any(take.sha256 == digest for take in self.profile.manifest.takes)

    def _talk(self) -> EnrolmentStep | None:
        there = [t.seconds for t in self.profile.manifest.takes if t.kind == TALK]
        missing = self._config.talk - sum(there)
        if missing <= 0.0:
            return None
        piece = self._config.talk_piece
        left = -(-missing // piece)
        return EnrolmentStep(TALK, "", piece, len(there) + 1, len(there) + int(left))


def require_letters(phrases: Iterable[str]) -> None:
    """Refuse a phrase that no profile can learn.

    Raises:
        VoiceProfileError: It has other letters than a to z.
    """
    for phrase in phrases:
        if not set("".join(normalize(phrase))) <= set(CHARACTERS):
            raise VoiceProfileError(f"{phrase!r}: a profile's phrases have letters a to z only")


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
        source="".join(c if c.isprintable() else "?" for c in source),
        seconds=len(samples) / RATE,
        level_db=checked.level_db,
        snr_db=checked.snr_db,
        heard=checked.heard,
        verdict=verdict,
    )

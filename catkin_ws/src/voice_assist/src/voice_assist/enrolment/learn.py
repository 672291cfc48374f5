# SPDX-License-Identifier: BSD-3-Clause
"""From the takes of a profile to adapted weights; for all of them, or without those of a fold."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from voice_assist.config.enrolment import AdaptConfig
from voice_assist.enrolment.adapt import Adapted, adapt
from voice_assist.enrolment.examples import Example, broken_off, other_voices, take_example, varied
from voice_assist.profile.manifest import COMMAND, TALK
from voice_assist.profile.profile import VoiceProfile
from voice_assist.recognizer.embedded import EmbeddedRecognizer
from voice_assist.types import LONGEST, RATE, Samples

_OTHERS_SNR = (5.0, 35.0)  # [dB]
_TALK_SNR = (20.0, 40.0)  # [dB] over the noise that the room has already
_TALK_PIECE = 3.0  # [s] of talk in one example
_TALK_COPIES = 2


@dataclass(frozen=True, eq=False)
class LabelledTake:
    """One take with its sound."""

    file: str
    phrase: str  # empty for talk
    samples: Samples


@dataclass(frozen=True, eq=False)
class EnrolmentMaterial:
    """What one person said."""

    takes: tuple[LabelledTake, ...]  # of commands
    talk: tuple[LabelledTake, ...]

    @property
    def said(self) -> Iterator[tuple[str, Samples]]:
        """Phrase and sound of each take."""
        return ((take.phrase, take.samples) for take in self.takes)

    @property
    def talked(self) -> float:
        """Length of the talk [h]."""
        return sum(len(one.samples) for one in self.talk) / RATE / 3600.0

    def split(self, fold: int, folds: int) -> tuple[EnrolmentMaterial, EnrolmentMaterial]:
        """What is learned from in a fold of the cross-validation, and what is left out of it.

        Every `folds`-th take of each command and piece of talk is left out, from `fold` on.
        """
        kept, left = (
            EnrolmentMaterial(
                tuple(t for t, n in _numbered(self.takes) if (n % folds == fold) is is_left),
                tuple(t for t, n in _numbered(self.talk) if (n % folds == fold) is is_left),
            )
            for is_left in (False, True)
        )
        return kept, left


def material_of(profile: VoiceProfile) -> EnrolmentMaterial:
    """Takes and talk of a profile.

    Raises:
        VoiceProfileError: A take is not as it was written.
    """

    def of(kind: str) -> tuple[LabelledTake, ...]:
        takes = (take for take in profile.manifest.takes if take.kind == kind)
        return tuple(LabelledTake(take.file, take.phrase, profile.sound(take)) for take in takes)

    return EnrolmentMaterial(of(COMMAND), of(TALK))


def others_for(phrases: Sequence[str], config: AdaptConfig) -> list[Example]:
    """Examples of other voices that are learned beside the person's, always the same.

    Raises:
        ModelError: espeak-ng is not installed.
    """
    rng = np.random.default_rng(config.seed)
    spoken = other_voices(phrases, config.others, config.seed)
    return [varied(example, rng, _OTHERS_SNR) for example in spoken]


def learn(
    base: EmbeddedRecognizer,
    material: EnrolmentMaterial,
    others: Sequence[Example],
    config: AdaptConfig,
) -> Adapted:
    """Adapt the base to a voice.

    What was said in the talk nobody wrote down; it is learned as the base writes it, so that it
    stays what it is.

    Args:
        base: Recogniser; it is not changed.
        material: Of the person.
        others: Of other voices.
        config: How to learn.
    """
    began = time.process_time()
    rng = np.random.default_rng(config.seed)
    own = []
    for take in material.takes:
        example = take_example(take.samples, take.phrase)
        own += [varied(example, rng) for _ in range(config.copies)]
        cut = (broken_off(base.model, example, rng) for _ in range(config.broken_off))
        own += [varied(part, rng) for part in cut if part is not None]
    pieces = [piece for one in material.talk for piece in _pieces(one.samples)]
    same = []
    for piece in pieces:
        for _ in range(_TALK_COPIES):
            sound = varied(Example(piece, ""), rng, _TALK_SNR)
            same.append(replace(sound, text=base.transcribe(sound.samples).text))
    adapted = adapt(base.model, own, [*others, *same], config)
    return replace(adapted, seconds=time.process_time() - began)


def _pieces(samples: Samples) -> list[Samples]:
    length = round(min(_TALK_PIECE, LONGEST) * RATE)
    cut = [samples[start : start + length] for start in range(0, len(samples), length)]
    return [piece for piece in cut if len(piece) > RATE // 2 and bool(np.any(piece))]


def _numbered(spoken: Sequence[LabelledTake]) -> list[tuple[LabelledTake, int]]:
    """Each with its number among those of its phrase."""
    counts: dict[str, int] = {}
    found = []
    for one in spoken:
        number = counts.get(one.phrase, 0)
        counts[one.phrase] = number + 1
        found.append((one, number))
    return found

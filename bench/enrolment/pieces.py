# SPDX-License-Identifier: BSD-3-Clause
"""One surgeon enrolled with so many repetitions, and what base and profile then hear."""

from __future__ import annotations

import resource
import sys
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

from bench.common.resumable import digest, remembered, source
from bench.enrolment import cast
from bench.enrolment.cast import EnrolledSpeech, Surgeon, material
from bench.enrolment.cast import SurgeonMaterial as Recorded
from support.figures import ROOT
from support.product_code import ENROLMENT, identity
from voice_assist.config import VoiceConfig, load_voice_config
from voice_assist.config.enrolment import EnrolmentConfig, load_enrolment_config
from voice_assist.enrolment import learn
from voice_assist.enrolment.examples import Example
from voice_assist.enrolment.pipeline_probe import PipelineProbe
from voice_assist.enrolment.takes.checks import TakeCheck
from voice_assist.profile.active import PersonalRecognizer
from voice_assist.profile.manifest import COMMAND
from voice_assist.recognizer import load_recognizer
from voice_assist.recognizer.embedded import EmbeddedRecognizer

FOLDER = ROOT / ".cache" / "enrolment" / "pieces"
_OTHER = 6  # sentences and near misses of each surgeon; hearing them takes most of the time


@dataclass(frozen=True)
class Counts:
    """What was taken."""

    n: int  # sounds
    right: int  # the command that was said, and no other
    another: int  # a command that was not said


@dataclass(frozen=True)
class EnrolmentPiece:
    """A surgeon after so many repetitions; 0: the base."""

    surgeon: str
    repetitions: int
    first: Counts  # of commands that were not enrolled, the first repetition
    later: Counts  # their others
    talk: Counts  # talk that was not enrolled
    near: Counts  # near misses
    stranger: Counts  # another's first commands, with this profile; of the base its own first ones
    refused: int = 0  # takes that the check asked for again
    seconds: float = 0.0  # [s] of CPU time to learn
    memory: float = 0.0  # [MB] largest resident set

    @property
    def tested(self) -> Counts:
        """All commands that were not enrolled."""
        one, other = self.first, self.later
        return Counts(one.n + other.n, one.right + other.right, one.another + other.another)

    @staticmethod
    def from_json(data: dict[str, Any]) -> EnrolmentPiece:
        """What was written of it."""
        counts = {k: Counts(**data[k]) for k in ("first", "later", "talk", "near", "stranger")}
        return EnrolmentPiece(**{**data, **counts})


@dataclass(frozen=True, eq=False)
class EnrolmentBench:
    """What every piece needs, loaded once."""

    voice: VoiceConfig
    config: EnrolmentConfig
    base: EmbeddedRecognizer
    others: list[Example]
    check: TakeCheck


@cache
def bench() -> EnrolmentBench:
    """The shipped model and settings."""
    voice, config = load_voice_config(), load_enrolment_config()
    base = load_recognizer()
    if not isinstance(base, EmbeddedRecognizer):
        raise TypeError(f"{type(base).__name__}, allowed: the embedded recogniser")
    phrases = voice.commands.phrases
    others = learn.others_for(phrases, config.adapt)
    return EnrolmentBench(
        voice, config, base, others, TakeCheck(config.checks, voice.commands, base)
    )


def piece(surgeon: Surgeon, stranger: Surgeon, repetitions: int) -> EnrolmentPiece:
    """Measure a surgeon, or find it measured."""
    path = _path(surgeon, repetitions)
    return EnrolmentPiece.from_json(
        remembered(path, lambda: asdict(_measure(surgeon, stranger, repetitions)))
    )


def is_done(surgeon: Surgeon, repetitions: int) -> bool:
    """Whether a piece is there."""
    return _path(surgeon, repetitions).is_file()


def _path(surgeon: Surgeon, repetitions: int) -> Path:
    return FOLDER / key() / f"{str(surgeon).replace(':', '_')}-{repetitions}.json"


@cache
def key() -> str:
    """Of the product that learns and hears, with its settings, and of what is said and counted."""
    return digest(identity(ENROLMENT), source(cast, sys.modules[__name__]))


def enrolled(
    said: Sequence[EnrolledSpeech], repetitions: int, is_fit: Callable[[EnrolledSpeech], bool]
) -> list[EnrolledSpeech]:
    """The first takes of each command that pass the check; the others are said again."""
    kept: list[EnrolledSpeech] = []
    for one in said:
        count = sum(take.text == one.text for take in kept)
        if count < repetitions and is_fit(one):
            kept.append(one)
    return kept


def spoken(
    takes: Sequence[EnrolledSpeech], talk: Sequence[EnrolledSpeech]
) -> learn.EnrolmentMaterial:
    """As a profile would hold them."""
    return learn.EnrolmentMaterial(
        tuple(learn.LabelledTake(f"{i}", take.text, take.samples) for i, take in enumerate(takes)),
        tuple(learn.LabelledTake(f"talk {i}", "", take.samples) for i, take in enumerate(talk)),
    )


def count(probe: PipelineProbe, said: Sequence[EnrolledSpeech], phrases: Sequence[str]) -> Counts:
    """Hear all of it."""
    taken = [(set(probe(one.samples).taken), one.text) for one in said]
    right = sum(found == {text} for found, text in taken)
    another = sum(bool(found - ({text} & set(phrases))) for found, text in taken)
    return Counts(len(said), right, another)


def _measure(surgeon: Surgeon, stranger: Surgeon, repetitions: int) -> EnrolmentPiece:
    shared = bench()
    recorded, phrases = material(surgeon), shared.voice.commands.phrases
    if repetitions == 0:
        return _heard(PipelineProbe(shared.voice, shared.base), surgeon, recorded, (), phrases)

    def is_fit(said: EnrolledSpeech) -> bool:
        checked = shared.check(COMMAND, said.text, said.samples)
        return checked.is_good or checked.is_unlike  # the second time it is taken as it is

    takes = enrolled(recorded.enrolled, repetitions, is_fit)
    refused = sum(not is_fit(said) for said in recorded.enrolled)
    learned = learn.learn(
        shared.base, spoken(takes, recorded.talk), shared.others, shared.config.adapt
    )
    probe = PipelineProbe(shared.voice, PersonalRecognizer(shared.base, learned.state))
    found = _heard(probe, surgeon, recorded, material(stranger).tested, phrases)
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    return replace(
        found, repetitions=repetitions, refused=refused, seconds=learned.seconds, memory=memory
    )


def _heard(
    probe: PipelineProbe,
    surgeon: Surgeon,
    recorded: Recorded,
    stranger: Sequence[EnrolledSpeech],
    phrases: Sequence[str],
) -> EnrolmentPiece:
    half, one_each = len(recorded.other) // 2, len(phrases)  # talk first, then near misses
    first = count(probe, recorded.tested[:one_each], phrases)
    return EnrolmentPiece(
        surgeon=str(surgeon),
        repetitions=0,
        first=first,
        later=count(probe, recorded.tested[one_each:], phrases),
        talk=count(probe, recorded.other[:half][:_OTHER], phrases),
        near=count(probe, recorded.other[half:][:_OTHER], phrases),
        stranger=count(probe, stranger[:one_each], phrases) if stranger else first,
    )

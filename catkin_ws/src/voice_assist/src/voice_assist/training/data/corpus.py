# SPDX-License-Identifier: BSD-3-Clause
"""Everything that training and its quick measurements listen to."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from voice_assist.training.data.human import (
    load_speech,
    load_surroundings,
    read_manifest,
    training_sentences,
)
from voice_assist.training.data.kokoro import spoken
from voice_assist.training.data.neural_voices import (
    folded,
    plan_foreign,
    plan_neural,
    plan_neural_texts,
)
from voice_assist.training.data.noise import Surroundings
from voice_assist.training.data.synthesis import (
    SynthesisAmounts,
    TrainingClip,
    plan_held_out,
    plan_texts,
    plan_training,
    speak_all,
    synthesise,
)
from voice_assist.training.data.texts import AMOUNTS, BEGINNINGS, TALK, TWINS

TALK_THIN = 5  # of the talk to measure on, one clip in so many


@dataclass(frozen=True, eq=False)
class Corpus:
    """Clips to learn from, and clips of other speakers to measure on."""

    train: list[TrainingClip]
    around: Surroundings
    held_out: list[TrainingClip]  # synthetic, in voices never trained on
    people: list[TrainingClip]  # human single words of split dev
    talk: list[TrainingClip]  # a part of split false_accept_dev; its text is not used


def load_corpus(
    speech: Path,
    cache: Path,
    seed: int,
    amounts: SynthesisAmounts,
    workers: int,
    packages: Path | None = None,
) -> Corpus:
    """Synthesise, or read from the cache, and load recordings where present.

    Args:
        speech: Folder with manifest.csv; synthetic speech alone where absent.
        cache: Folder for synthetic sound.
        seed: Of all chance.
        amounts: Synthetic prompts.
        workers: Processes that synthesise.
        packages: Of Kokoro's voices, where they and words of other languages are wanted.

    Raises:
        ModelError: A package of Kokoro's is missing.
    """
    rows, recordings = read_manifest(speech), cache / "recordings"
    sentences = training_sentences(rows) + list(TALK)
    prompts = plan_training(sentences, seed, amounts)
    train = synthesise(prompts, cache / "synthetic", workers)
    for said, amount, name in (
        (TWINS, amounts.twin, "twins"),
        (BEGINNINGS, amounts.beginning, "beginnings"),
        (AMOUNTS, amounts.amount, "amounts"),
    ):
        train += synthesise(plan_texts(said, seed, amount), cache / name, workers)
    if packages:
        train += spoken(plan_neural(sentences), packages, cache / "neural")
        if amounts.amount:
            train += spoken(plan_neural_texts(), packages, cache / "neural_texts")
        train += _foreign(seed, cache / "foreign", workers)
    human = [c for c in load_speech(rows, "train", recordings) if c.text and c.text.isascii()]
    talkers = [clip.samples for clip in [*human, *train] if len(clip.samples) > 24000]
    talk = load_speech(rows, "false_accept_dev", recordings, longest=10.0)[::TALK_THIN]
    return Corpus(
        train=train + human,
        around=load_surroundings(rows, np.random.default_rng(seed), talkers),
        held_out=synthesise(plan_held_out(seed), cache / "held_out", workers),
        people=load_speech(rows, "dev", recordings),
        talk=talk,
    )


def _foreign(seed: int, cache: Path, workers: int) -> list[TrainingClip]:
    """Words of other languages, written in the recogniser's letters."""
    return [
        TrainingClip(sound, folded(prompt.text), "foreign", f"espeak:{prompt.voice}")
        for prompt, sound in speak_all(plan_foreign(seed), cache, workers)
    ]

# SPDX-License-Identifier: BSD-3-Clause
"""The synthetic corpus: planned from a seed, spoken once, kept in a cache."""

from __future__ import annotations

import hashlib
import multiprocessing
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from itertools import cycle, groupby, islice
from pathlib import Path
from random import Random

import numpy as np

from voice_assist.audio.espeak import Int16
from voice_assist.training.array_file import write_arrays
from voice_assist.training.data import texts, voices
from voice_assist.training.data.homophones import same_as_command
from voice_assist.training.data.voices import Engine, Prompt, by_voice, random_style, speak_in_turn

CHUNK = 200  # prompts per cache file
NOTHING = np.zeros(0, np.int16)
_NEAR = frozenset((*texts.NEAR_MISSES, *texts.HARD))


@dataclass(frozen=True, eq=False)
class TrainingClip:
    """A sound and what is said in it."""

    samples: Int16  # (n,), 16 kHz mono
    text: str  # normalised; empty for noise
    kind: str  # "command", "variant", "near", "talk", "span", or a human kind
    speaker: str


@dataclass(frozen=True)
class SynthesisAmounts:
    """How many prompts of each kind to plan."""

    command: int = 9000
    variant: int = 3000
    near: int = 7000
    hard: int = 7000
    talk: int = 2500
    span: int = 12000
    short: int = 4000  # spans of one or two words
    twin: int = 0  # what is most like a command, for the lessons "twins" and "voices"
    beginning: int = 0  # what begins like a command, for the lessons "beginnings" and "amounts"
    amount: int = 0  # numbers with units, for the lesson "amounts"

    def part(self, share: float) -> SynthesisAmounts:
        """A share of each."""
        return SynthesisAmounts(**{kind: round(n * share) for kind, n in asdict(self).items()})


def plan_training(sentences: Sequence[str], seed: int, amounts: SynthesisAmounts) -> list[Prompt]:
    """Prompts for training, grouped by voice; no held-out voice speaks."""
    rng = Random(seed)
    variants, _ = voices.espeak_variants()
    said = _in_turn(texts.COMMANDS, amounts.command)
    said += [texts.command_variant(rng) for _ in range(amounts.variant)]
    said += _in_turn(texts.NEAR_MISSES, amounts.near)
    said += _in_turn(texts.HARD, amounts.hard)
    said += _in_turn(texts.TALK, amounts.talk)
    for _ in range(amounts.span):
        is_number = rng.random() < 0.1
        span = texts.word_span(sentences, rng)
        said.append(texts.number_phrase(rng) if is_number else span)
    said += [texts.word_span(sentences, rng, longest=2) for _ in range(amounts.short)]
    return _cast(said, variants, rng)


def plan_texts(said: Sequence[str], seed: int, amount: int) -> list[Prompt]:
    """So many prompts of these texts, grouped by voice; no held-out voice speaks."""
    rng = Random(seed)
    variants, _ = voices.espeak_variants()
    return _cast(_in_turn(said, amount), variants, rng)


def _in_turn(said: Sequence[str], count: int) -> list[str]:
    return list(islice(cycle(said), count))


def _cast(said: Sequence[str], variants: list[str], rng: Random) -> list[Prompt]:
    """A voice for each text, but for those that sound like a command in it."""
    cast = (cast_voice(text, variants, rng) for text in said)
    prompts = [p for p in cast if not _is_homophone(p)]
    return sorted(prompts, key=by_voice)


def plan_held_out(seed: int, per_voice: int = 2) -> list[Prompt]:
    """Commands and near misses in the voices that training never hears."""
    rng = Random(seed + 1)
    _, variants = voices.espeak_variants()
    cast: list[tuple[Engine, str]] = []
    for variant in variants:
        accents = (voices.HELD_OUT_ACCENT, rng.choice(voices.ACCENTS))
        cast += [("espeak", f"{accent}+{variant}") for accent in accents]
    cast += [("flite", name) for name in voices.HELD_OUT_FLITE] * 3
    cast += [("festival", name) for name in voices.HELD_OUT_FESTIVAL] * 3
    prompts = []
    for engine, voice in cast:
        near = rng.sample(texts.NEAR_MISSES, 5)
        for text in [*texts.COMMANDS * per_voice, *near]:
            rate, pitch = rng.uniform(0.85, 1.2), rng.uniform(0.35, 0.65)
            prompts.append(Prompt(text, engine, voice, rate, pitch))
    return sorted(prompts, key=by_voice)


def synthesise(prompts: Sequence[Prompt], cache: Path, workers: int = 2) -> list[TrainingClip]:
    """Speak all prompts, as clips to train with; see speak_all."""
    return [
        TrainingClip(sound, texts.normalise_text(p.text), _kind(p.text), f"{p.engine}:{p.voice}")
        for p, sound in speak_all(prompts, cache, workers)
    ]


def speak_all(
    prompts: Sequence[Prompt], cache: Path, workers: int = 2
) -> list[tuple[Prompt, Int16]]:
    """Speak all prompts, reusing what the cache already holds.

    Args:
        prompts: Sorted by engine and voice.
        cache: Folder for the sound; made if missing.
        workers: Processes to speak with.

    Returns:
        The prompts that the engines could speak, with their sound.
    """
    cache.mkdir(parents=True, exist_ok=True)
    groups = [list(g) for _, g in groupby(prompts, key=lambda p: (p.engine, p.voice))]
    chunks: list[list[Prompt]] = [[]]
    for group in groups:
        chunks[-1] += group
        if len(chunks[-1]) >= CHUNK:
            chunks.append([])
    jobs = [(chunk, _path(chunk, cache)) for chunk in chunks if chunk]
    missing = [job for job in jobs if not job[1].exists()]
    if missing:
        with multiprocessing.get_context("spawn").Pool(workers) as pool:
            pool.map(_speak_chunk, missing, chunksize=1)
    return [
        (prompt, sound)
        for chunk, path in jobs
        for prompt, sound in zip(chunk, read_sounds(path), strict=True)
        if len(sound)
    ]


def _path(prompts: list[Prompt], cache: Path) -> Path:
    key = hashlib.sha256(repr(prompts).encode()).hexdigest()[:24]
    return cache / f"{key}.npz"


def _speak_chunk(job: tuple[list[Prompt], Path]) -> None:
    prompts, path = job
    sounds = (sound for _, sound in speak_in_turn(prompts))
    save_sounds([NOTHING if sound is None else sound for sound in sounds], path)


def save_sounds(sounds: Sequence[Int16], path: Path) -> None:
    """Write sounds to one file, all or nothing."""
    ends = np.cumsum([len(sound) for sound in sounds])
    write_arrays(path, sound=np.concatenate(sounds), ends=ends)


def read_sounds(path: Path) -> list[Int16]:
    """Sounds of a file that save_sounds wrote."""
    with np.load(path) as stored:
        return np.split(stored["sound"], stored["ends"][:-1])


def _kind(text: str) -> str:
    if text in texts.COMMANDS:
        return "command"
    if text in _NEAR:
        return "near"
    if text in texts.BEGINNINGS:
        return "beginning"
    if text in texts.AMOUNTS:
        return "amount"
    is_variant = any(text.count(command) for command in texts.COMMANDS) and len(text) < 30
    return "variant" if is_variant else "span"


def _is_homophone(prompt: Prompt) -> bool:
    return _kind(prompt.text) in ("near", "beginning") and same_as_command(
        prompt.text, prompt.engine, prompt.voice
    )


def cast_voice(text: str, variants: list[str], rng: Random) -> Prompt:
    """Choose a voice and a way of speaking for a text."""
    rate, pitch = random_style(rng)
    prompt = Prompt(text, "espeak", "", rate, pitch)
    kind = rng.random()
    if kind < 0.60:
        voice = f"{rng.choice(voices.ACCENTS)}+{rng.choice(variants)}"
        return replace(prompt, voice=voice)
    if kind < 0.76:
        voice = f"{rng.choice(voices.FOREIGN)}+{rng.choice(variants)}"
        return replace(prompt, engine="phonemes", voice=voice)
    if kind < 0.82:
        return replace(prompt, engine="flite", voice=rng.choice(voices.FLITE))
    if kind < 0.94:
        return replace(prompt, engine="rhvoice", voice=rng.choice(voices.RHVOICE))
    return replace(prompt, engine="festival", voice=rng.choice(voices.FESTIVAL))

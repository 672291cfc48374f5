# SPDX-License-Identifier: BSD-3-Clause
"""What adaptation learns from: takes said again a little differently, takes broken off, others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from random import Random

import numpy as np
import torch
from numpy.random import Generator

from voice_assist.profile.loudness import speech_of
from voice_assist.recognizer.ctc import best_alignment
from voice_assist.recognizer.hybrid import WhisperCtc
from voice_assist.recognizer.mel import SAMPLES_PER_STATE, log_mel
from voice_assist.recognizer.vocabulary import encode, spelled
from voice_assist.training.data import texts, voices
from voice_assist.training.data.noise import coloured
from voice_assist.training.data.voices import Engine, Prompt, espeak_variants, speak_in_turn
from voice_assist.types import RATE, Samples

GRID = 5120  # samples of which lengths are multiples, so that many examples share one
LONGEST = 12 * GRID  # samples; a longer sound is learned from its beginning
_SPEED = (0.9, 1.1)
_QUIET = (0.05, 0.4)  # [s] before and behind
_SNR = (10.0, 35.0)  # [dB]
_COLOUR = 2.0  # [dB] standard deviation of a microphone's curve
_CURVE = (0.0, 150.0, 400.0, 1000.0, 2000.0, 4000.0, 8000.0)  # [Hz]
_PEAK = (-22.0, -3.0)  # [dB] of full scale
_SHARE_FOREIGN = 0.4  # of the other voices
_LONGEST_OTHER = round(2.6 * RATE)  # samples; varied, it is still shorter than LONGEST


@dataclass(frozen=True, eq=False)
class Example:
    """A sound and what is written for it."""

    samples: Samples  # (n,), n a multiple of GRID where it was varied
    text: str  # letters, space and apostrophe; empty for no words


def varied(example: Example, rng: Generator, snr: tuple[float, float] = _SNR) -> Example:
    """The same said at another speed, over other noise, into another microphone."""
    speed = rng.uniform(*_SPEED)
    length = int(len(example.samples) / speed)
    at = np.arange(length) * speed
    sound = np.interp(at, np.arange(len(example.samples)), example.samples)
    before, after = (round(quiet * RATE) for quiet in rng.uniform(*_QUIET, 2))
    whole = -(-(before + length + after) // GRID) * GRID
    sound = np.pad(sound, (before, whole - before - length))
    gain = np.interp(
        np.linspace(0.0, RATE / 2, whole // 2 + 1), _CURVE, rng.normal(0.0, _COLOUR, len(_CURVE))
    )
    sound = np.fft.irfft(np.fft.rfft(sound) * 10.0 ** (gain / 20.0), whole)
    loud = np.sqrt(np.sum(np.square(sound)) / max(length, 1)) + 1e-6
    noise = coloured(whole, rng.uniform(0.3, 1.7), rng)
    noise *= loud * 10.0 ** (-rng.uniform(*snr) / 20.0) / (noise.std() + 1e-9)
    sound = (sound + noise)[:LONGEST]
    peak = 10.0 ** (rng.uniform(*_PEAK) / 20.0)
    return Example(np.asarray(sound * (peak / np.abs(sound).max()), np.float32), example.text)


def take_example(samples: Samples, text: str) -> Example:
    """A take without most of the quiet around it."""
    return Example(speech_of(samples, 0.03), spelled(text))


def broken_off(model: WhisperCtc, example: Example, rng: Generator) -> Example | None:
    """A take that ends in the middle, with the letters heard so far; None: it has no middle.

    Partial transcripts are made while a command is still being said; so a model that learned whole
    takes alone would write the whole of them too early.

    Args:
        model: Its CTC head aligns letters and sound.
        example: A whole take.
        rng: Chooses where it ends.
    """
    ids = np.array(encode(example.text), np.int64)
    with torch.inference_mode():
        states = model.encode(log_mel(torch.from_numpy(np.array(example.samples))[None]))
        emitted = model.ctc_logprobs(states)[0].numpy()
    likelihood, frames = best_alignment(emitted, ids)
    if len(ids) < 3 or not np.isfinite(likelihood):
        return None
    kept = int(rng.integers(1, len(ids) - 1))
    between = (int(frames[kept - 1]) + int(frames[kept])) // 2 + 1
    sound = example.samples[: between * SAMPLES_PER_STATE]
    if len(sound) < 2 * SAMPLES_PER_STATE:
        return None
    return Example(sound, example.text[:kept].strip())


def other_voices(
    phrases: Sequence[str], count: int, seed: int, *, are_held_out: bool = False
) -> list[Example]:
    """What must not be forgotten: commands, near misses and talk by voices of espeak-ng.

    Args:
        phrases: Of the commands.
        count: How many examples.
        seed: The same seed gives the same examples.
        are_held_out: By variants of voices that the base was not trained on; else by its own.

    Raises:
        ModelError: As `espeak_variants`.
    """
    rng = Random(seed)
    trained, held_out = espeak_variants()
    variants = held_out if are_held_out else trained
    near = (*texts.NEAR_MISSES, *texts.HARD)
    said = [phrases[i % len(phrases)] for i in range(count // 3)]
    said += [rng.choice(near) for _ in range(count // 2)]
    said += [rng.choice(texts.TALK) for _ in range(count - len(said))]
    prompts = sorted(
        (_cast(text, variants, rng) for text in said), key=lambda p: (p.engine, p.voice)
    )
    spoken: list[Example] = []
    for prompt, sound in speak_in_turn(prompts):
        if sound is not None and len(sound) <= _LONGEST_OTHER:
            samples = sound.astype(np.float32) / np.float32(32768)
            is_command = prompt.text in phrases  # labelled as a take of it is
            label = spelled(prompt.text) if is_command else texts.normalise_text(prompt.text)
            spoken.append(Example(samples, label))
    return spoken


def _cast(text: str, variants: Sequence[str], rng: Random) -> Prompt:
    is_foreign = rng.random() < _SHARE_FOREIGN
    engine: Engine = "phonemes" if is_foreign else "espeak"
    language = rng.choice(voices.FOREIGN if is_foreign else voices.ACCENTS)
    rate, pitch = rng.uniform(0.8, 1.25), rng.uniform(0.3, 0.7)
    return Prompt(text, engine, f"{language}+{rng.choice(variants)}", rate, pitch)

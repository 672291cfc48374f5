# SPDX-License-Identifier: BSD-3-Clause
"""Stand-in surgeons: voices and accents that training never used, and what each of them says."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path
from random import Random

import numpy as np
import soxr
from numpy.typing import NDArray

from bench.voice.material.held_out_voices import foreigners, natives
from support.figures import ROOT
from voice_assist.training.data import texts
from voice_assist.training.data.noise import build_rooms, coloured
from voice_assist.training.data.synthesis import read_sounds, save_sounds
from voice_assist.training.data.voices import Engine, Prompt, espeak_variants, speak
from voice_assist.types import RATE, Samples

# Languages whose voices training never had speak English; none is in voices.FOREIGN.
ACCENTS = ("fi", "hu", "cs", "ro", "da", "nb", "el", "id", "sw", "ca", "ru", "sk", "lt", "et")
MAX_REPETITIONS = 10  # enrolled repetitions of a command
TESTED = 3  # repetitions that are not enrolled
SENTENCES = 12  # of free talk, and as many others that are not enrolled


@dataclass(frozen=True, order=True)
class Surgeon:
    """One stand-in."""

    engine: Engine
    voice: str

    def __str__(self) -> str:
        """Engine and voice."""
        return f"{self.engine}:{self.voice}"


@dataclass(frozen=True, eq=False)
class EnrolledSpeech:
    """One recording of a surgeon."""

    text: str
    samples: Samples  # (n,), 16 kHz, with the room's quiet around it


@dataclass(frozen=True, eq=False)
class SurgeonMaterial:
    """All that one surgeon said."""

    enrolled: tuple[EnrolledSpeech, ...]  # of each command, one of each after the other
    tested: tuple[EnrolledSpeech, ...]  # TESTED of each command, in another room and on another day
    talk: tuple[EnrolledSpeech, ...]  # free talk that is enrolled
    other: tuple[EnrolledSpeech, ...]  # talk and near misses that are not


def surgeons() -> tuple[Surgeon, ...]:
    """All that this machine can speak as, in a mixed order that is always the same."""
    cast = [Surgeon(v.engine, v.name) for v in (*foreigners().present, *natives().present)]
    cast = [s for s in cast if s.engine != "espeak"]
    _, variants = espeak_variants()
    cast += [Surgeon("espeak", f"en-gb-x-gbcwmd+{variant}") for variant in variants[::4]]
    voices = zip(ACCENTS, variants, strict=False)
    cast += [Surgeon("phonemes", f"{accent}+{variant}") for accent, variant in voices]
    return tuple(sorted(cast, key=lambda s: hashlib.sha256(str(s).encode()).digest()))


def material(surgeon: Surgeon, seed: int = 0) -> SurgeonMaterial:
    """Speak all that a surgeon says; the same each time."""
    key = hashlib.sha256(f"{surgeon} {seed}".encode()).digest()
    rng = Random(key)
    chance = np.random.default_rng(list(key))
    lines = [(text, "enrolled") for _ in range(MAX_REPETITIONS) for text in texts.COMMANDS]
    lines += [(text, "tested") for _ in range(TESTED) for text in texts.COMMANDS]
    sentences = rng.sample(texts.TALK, 2 * SENTENCES)
    lines += [(text, "talk") for text in sentences[:SENTENCES]]
    lines += [(text, "other") for text in sentences[SENTENCES:]]
    lines += [(text, "other") for text in rng.sample((*texts.NEAR_MISSES, *texts.HARD), SENTENCES)]
    usual_rate, usual_pitch = rng.uniform(0.9, 1.1), rng.uniform(0.4, 0.6)
    prompts = []
    for text, _ in lines:
        rate = usual_rate * rng.uniform(0.85, 1.18)
        pitch = usual_pitch + rng.uniform(-0.12, 0.12)
        prompts.append(Prompt(text, surgeon.engine, surgeon.voice, rate, pitch))
    cache = ROOT / ".cache" / "enrolment" / "spoken"
    sounds = _spoken(prompts, cache / f"{key.hex()[:24]}.npz")
    rooms = build_rooms([], chance, count=2)
    found: dict[str, list[EnrolledSpeech]] = {"enrolled": [], "tested": [], "talk": [], "other": []}
    for (text, where), sound in zip(lines, sounds, strict=True):
        is_enrolled = where in ("enrolled", "talk")
        room = rooms[0 if is_enrolled else 1]
        snr = chance.uniform(20.0, 35.0) if is_enrolled else chance.uniform(12.0, 35.0)
        found[where].append(EnrolledSpeech(text, _recorded(sound, room, snr, chance)))
    return SurgeonMaterial(
        *(tuple(found[name]) for name in ("enrolled", "tested", "talk", "other"))
    )


def _spoken(prompts: list[Prompt], cache: Path) -> list[NDArray[np.int16]]:
    """Speak prompts once; a voice that is silent on one of them cannot stand in.

    Raises:
        RuntimeError: The voice gave no sound.
    """
    if not cache.is_file():
        sounds = [sound for sound in speak(prompts) if sound is not None]
        if len(sounds) != len(prompts):
            raise RuntimeError(f"{prompts[0].voice}: {len(sounds)} of {len(prompts)} spoken")
        cache.parent.mkdir(parents=True, exist_ok=True)
        save_sounds(sounds, cache)
    return read_sounds(cache)


def _recorded(
    sound: NDArray[np.int16], room: Samples, snr: float, rng: np.random.Generator
) -> Samples:
    """A voice a little longer or shorter, in a room, at some level, over the room's noise."""
    speech = sound.astype(np.float32) / np.float32(32768)
    speech = soxr.resample(speech, RATE, RATE * rng.uniform(0.96, 1.04))
    speech = np.convolve(speech, room)[: len(speech) + len(room) // 4]
    around = np.pad(speech, (round(0.25 * RATE), round(0.25 * RATE)))
    loud = np.sqrt(np.mean(np.square(speech))) + 1e-9
    noise = coloured(len(around), rng.uniform(0.5, 1.5), rng)
    noise *= loud * 10 ** (-snr / 20) / (np.sqrt(np.mean(np.square(noise))) + 1e-9)
    mixed = around + noise
    peak = 10 ** (rng.uniform(-20.0, -4.0) / 20)
    return np.asarray(mixed * (peak / np.abs(mixed).max()), np.float32)

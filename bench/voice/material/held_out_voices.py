# SPDX-License-Identifier: BSD-3-Clause
"""The voices that training never used, by engine; which of them this machine can speak with."""

from __future__ import annotations

import subprocess
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from random import Random

from voice_assist.errors import ModelError
from voice_assist.training.data import voices
from voice_assist.training.data.voices import Engine, Prompt, by_voice, espeak_variants, speak

RHVOICE_DATA = Path("/usr/share/RHVoice/voices")  # of Debian's packages; one folder per voice
RATES, PITCHES = (0.85, 1.2), (0.35, 0.65)


@dataclass(frozen=True, order=True)
class SyntheticVoice:
    """One synthetic voice."""

    engine: Engine
    name: str

    def __str__(self) -> str:
        """As the training's figures name it."""
        return f"{self.engine}:{self.name}"


@dataclass(frozen=True)
class Cast:
    """Voices asked for."""

    present: tuple[SyntheticVoice, ...]
    missing: tuple[SyntheticVoice, ...]  # not installed here


@cache
def natives() -> Cast:
    """Held-out English voices; each speaks the same number of trials."""
    _, variants = espeak_variants()
    asked = [
        SyntheticVoice("espeak", f"{voices.HELD_OUT_ACCENT}+{variant}") for variant in variants
    ]
    asked += [SyntheticVoice("flite", name) for name in voices.HELD_OUT_FLITE]
    asked += [SyntheticVoice("festival", name) for name in voices.HELD_OUT_FESTIVAL]
    asked += [SyntheticVoice("rhvoice", name) for name in voices.HELD_OUT_RHVOICE]
    asked += [SyntheticVoice("pico", name) for name in voices.PICO]
    asked += [SyntheticVoice("mbrola", name) for name in voices.MBROLA_NATIVE]
    return _sorted_out(asked)


@cache
def foreigners() -> Cast:
    """Voices of other languages that speak English."""
    return _sorted_out([SyntheticVoice("mbrola", name) for name in voices.MBROLA_FOREIGN])


def spread(
    texts: Sequence[str], cast: Sequence[SyntheticVoice], each: int, seed: int
) -> list[Prompt]:
    """Each text by each voice so many times, each time at another rate and pitch.

    Args:
        texts: What is said.
        cast: Who says it.
        each: Times per text and voice.
        seed: The same seed gives the same rates and pitches.

    Returns:
        Sorted by engine and voice, as synthesis wants them.
    """
    rng = Random(seed)
    prompts = []
    for voice in cast:
        for text in texts:
            for _ in range(each):
                rate, pitch = rng.uniform(*RATES), rng.uniform(*PITCHES)
                prompts.append(Prompt(text, voice.engine, voice.name, rate, pitch))
    return sorted(prompts, key=by_voice)


def _sorted_out(asked: Sequence[SyntheticVoice]) -> Cast:
    present = tuple(voice for voice in asked if _speaks(voice))
    missing = tuple(voice for voice in asked if voice not in present)
    if missing:
        names = ", ".join(map(str, missing))
        print(f"voices that are not installed, left out: {names}", flush=True)
    return Cast(present, missing)


def _speaks(voice: SyntheticVoice) -> bool:
    """Whether the voice is there; flite and RHVoice would quietly take another for it."""
    try:
        if voice.engine == "flite" and voice.name not in _flite_voices():
            return False
        if voice.engine == "rhvoice" and not (RHVOICE_DATA / voice.name).is_dir():
            return False
        return speak([Prompt("stop", voice.engine, voice.name, 1.0, 0.5)])[0] is not None
    except (ModelError, OSError, subprocess.CalledProcessError):
        return False


@cache
def _flite_voices() -> tuple[str, ...]:
    listing = subprocess.run(["flite", "-lv"], check=True, capture_output=True, text=True)
    return tuple(listing.stdout.partition(":")[2].split())

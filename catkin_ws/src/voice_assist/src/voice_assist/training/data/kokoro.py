# SPDX-License-Identifier: BSD-3-Clause
"""The neural voices of Kokoro-82M: which there are, what they say, and the sound, spoken once."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

from voice_assist.answers.kokoro import Kokoro
from voice_assist.audio.espeak import Int16
from voice_assist.training.data.accents import english
from voice_assist.training.data.synthesis import TrainingClip, read_sounds, save_sounds

# Voices that only tests hear are in no list here: am_eric, am_onyx, af_nova, af_river, bf_lily,
# bm_daniel and all hf_, hm_, if_, im_, zf_, zm_; and six of this project's own tests: af_sky,
# am_puck, bf_emma, bm_fable, ef_dora, jm_kumo.
NATIVE = (
    *("af_alloy", "af_aoede", "af_bella", "af_heart", "af_jessica", "af_kore"),
    *("af_nicole", "af_sarah", "am_adam", "am_echo", "am_fenrir", "am_liam"),
    *("am_michael", "am_santa", "bf_alice", "bf_isabella", "bm_george", "bm_lewis"),
)
FOREIGN = (
    *("em_alex", "em_santa", "ff_siwis", "jf_alpha", "jf_gongitsune"),
    *("jf_nezumi", "jf_tebukuro", "pf_dora", "pm_alex", "pm_santa"),
)
LANGUAGES = {"e": "es", "f": "fr-fr", "j": "ja", "p": "pt-br"}  # by first letter of a voice
SPEEDS = (0.8, 1.0, 1.25)
_NEAR_STOP = ("top", "step", "stuff", "up", "stopped", "stock", "shop")


@dataclass(frozen=True)
class KokoroPrompt:
    """Some sounds in one voice."""

    text: str  # that they are
    sounds: str  # as the network knows them (IPA)
    voice: str
    speed: float
    kind: str = "word"  # of the training clip


def is_british(voice: str) -> bool:
    """Whether a voice's vowels are British."""
    return voice.startswith("b")


def plan_words() -> list[KokoroPrompt]:
    """Every voice says "stop", natives twice, and two near words, each at another speed."""
    prompts = []
    for number, voice in enumerate((*NATIVE, *FOREIGN)):
        texts = ["stop"] * (2 if voice in NATIVE else 1)
        texts += [_NEAR_STOP[(2 * number + i) % len(_NEAR_STOP)] for i in range(2)]
        prompts += [
            KokoroPrompt(
                text,
                english(text, british=is_british(voice)),
                voice,
                SPEEDS[(number + i) % len(SPEEDS)],
            )
            for i, text in enumerate(texts)
        ]
    return prompts


def speak(
    prompts: Sequence[KokoroPrompt], packages: Path, cache: Path
) -> list[tuple[KokoroPrompt, Int16]]:
    """Sound of every prompt, spoken once and kept, one file for each voice.

    Args:
        prompts: In any order.
        packages: Folder with the packages of PyPI and, in `package`, that of npm.
        cache: Folder for the sound.

    Returns:
        The prompts by voice, and each one's sound.

    Raises:
        ModelError: A package is missing.
    """
    cache.mkdir(parents=True, exist_ok=True)
    kokoro: Kokoro | None = None
    found: list[tuple[KokoroPrompt, Int16]] = []
    by_voice = sorted(prompts, key=lambda prompt: prompt.voice)
    for voice, group in groupby(by_voice, key=lambda prompt: prompt.voice):
        said = list(group)
        key = hashlib.sha256(repr(said).encode()).hexdigest()[:12]
        path = cache / f"{voice}_{key}.npz"
        if not path.exists():
            kokoro = kokoro or Kokoro(packages, packages / "package" / "voices")
            save_sounds([kokoro(p.sounds, p.voice, p.speed) for p in said], path)
        found += zip(said, read_sounds(path), strict=True)
    return found


def spoken(prompts: Sequence[KokoroPrompt], packages: Path, cache: Path) -> list[TrainingClip]:
    """The same as clips to train with."""
    return [
        TrainingClip(sound, prompt.text, prompt.kind, f"kokoro:{prompt.voice}")
        for prompt, sound in speak(prompts, packages, cache)
    ]

# SPDX-License-Identifier: BSD-3-Clause
"""Words and short talk of other languages as sound, by espeak-ng, MBROLA and Kokoro.

Kokoro speaks where its packages lie in .cache/training/openai, where `make train` puts them, or in
the folder that KOKORO names.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from random import Random

import soundfile

from bench.common.resumable import CACHE, digest
from bench.voice.material.foreign_words import LANGUAGES, NAMED
from bench.voice.material.held_out_voices import PITCHES, RATES
from bench.voice.material.synthesis import SpokenClip, spoken
from support.figures import ROOT
from voice_assist.audio.espeak import ipa
from voice_assist.errors import ModelError
from voice_assist.training.data.accents import english, for_kokoro
from voice_assist.training.data.kokoro import SPEEDS, KokoroPrompt, is_british, speak
from voice_assist.training.data.voices import Prompt, by_voice, espeak_variants
from voice_assist.types import RATE

SEED = 19
NEAR_VOICES, NAMED_VOICES = 2, 8  # of espeak-ng for each word; all others have one
NATIVE_STYLES = ("af_sky", "am_puck", "bf_emma", "bm_fable")
FOREIGN_STYLES = {"ef_dora": "Spanish", "jm_kumo": "Japanese"}  # and the sounds of their language
FOREIGN_SOUNDS = ("Hindi", "Italian", "Chinese", "German")
PACKAGES = Path(os.environ.get("KOKORO", ROOT / ".cache" / "training" / "openai"))


def by_espeak() -> dict[str, list[SpokenClip]]:
    """Clips by the kind of what is said: near words, words, talk, named; near words by MBROLA."""
    _, variants = espeak_variants()
    rng = Random(SEED)

    def cast(text: str, language: str, voices: int) -> Iterator[Prompt]:
        for variant in rng.sample(variants, voices):
            style = rng.uniform(*RATES), rng.uniform(*PITCHES)
            yield Prompt(text, "espeak", f"{language}+{variant}", *style)

    plan: dict[str, list[Prompt]] = {"near words": [], "words": [], "talk": [], "named": []}
    for one in LANGUAGES.values():
        for kind, texts in (("near words", one.near), ("words", one.words), ("talk", one.talk)):
            voices = NEAR_VOICES if kind == "near words" else 1
            for text in texts.split("|"):
                plan[kind] += cast(text, one.voice, voices)
    for language, text in NAMED:
        plan["named"] += cast(text, language, NAMED_VOICES)
    plan["MBROLA"] = [
        Prompt(text, "mbrola", name, 1.0, 0.5)
        for one in LANGUAGES.values()
        for name in one.diphones
        for text in one.near.split("|")
    ]
    return {kind: spoken(sorted(prompts, key=by_voice)) for kind, prompts in plan.items()}


def by_kokoro() -> list[SpokenClip]:
    """Near words in Kokoro's voices; none where its packages are missing."""
    return in_kokoro(
        [
            (text, one.voice, style)
            for one in LANGUAGES.values()
            for style in one.styles
            for text in one.near.split("|")
        ]
    )


def in_kokoro(said: Sequence[tuple[str, str, str]]) -> list[SpokenClip]:
    """Texts in Kokoro's voices; none where its packages are missing.

    Args:
        said: Text, language of espeak-ng whose sounds it has, style of Kokoro.
    """
    return _by_kokoro(
        [
            KokoroPrompt(text, for_kokoro(ipa(text, voice)), style, 1.0)
            for text, voice, style in said
        ]
    )


def commands_by_kokoro(commands: Sequence[str]) -> dict[str, list[SpokenClip]]:
    """English commands in six styles that training never hears, and in other languages' sounds.

    The sounds are made by the rules that training has, the styles are others. A style of another
    language says English sounds, too.
    """
    said = [(style, speed, "") for style in NATIVE_STYLES for speed in SPEEDS]
    accented = [(style, 1.0, accent) for style in NATIVE_STYLES for accent in FOREIGN_SOUNDS]
    for style, own in FOREIGN_STYLES.items():
        accented += [(style, 1.0, ""), (style, 1.0, own)]
    return {
        name: _by_kokoro(
            [
                KokoroPrompt(
                    text, english(text, british=is_british(style), accent=accent), style, speed
                )
                for style, speed, accent in cast
                for text in commands
            ]
        )
        for name, cast in (("Kokoro's natives", said), ("Kokoro's accents", accented))
    }


def _by_kokoro(prompts: Sequence[KokoroPrompt]) -> list[SpokenClip]:
    """Clips of prompts; none where a package is missing."""
    folder = CACHE / "kokoro" / digest(prompts)
    try:
        spoken_ones = speak(prompts, PACKAGES, folder)
    except ModelError as error:
        print(f"Kokoro left out: {error}")
        return []
    clips = []
    for number, (prompt, sound) in enumerate(spoken_ones):
        path = folder / f"{number:03d}.wav"
        if not path.is_file():
            soundfile.write(path, sound, RATE)
        clips.append(SpokenClip(str(path.relative_to(ROOT)), prompt.text, "kokoro", prompt.voice))
    return clips


def language_of(engine: str, voice: str) -> str:
    """Name of the language that a voice of this module speaks."""
    for name, one in LANGUAGES.items():
        if voice in (*one.styles, *one.diphones) or (
            engine == "espeak" and voice.partition("+")[0] == one.voice
        ):
            return name
    raise KeyError(f"{engine}:{voice}")

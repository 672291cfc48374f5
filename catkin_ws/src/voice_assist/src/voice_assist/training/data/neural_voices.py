# SPDX-License-Identifier: BSD-3-Clause
"""What Kokoro's voices say for the recogniser: commands, near words, talk, words of their language.

A text that sounds like a command in the accent that it is said in is left out: to train such a
sound as no command teaches the network to refuse commands.
"""

from __future__ import annotations

import unicodedata
from collections.abc import Iterator, Sequence
from random import Random

from voice_assist.audio.espeak import ipa
from voice_assist.training.data import texts
from voice_assist.training.data.accents import ACCENTS, english, for_kokoro
from voice_assist.training.data.foreign_words import WORDS
from voice_assist.training.data.kokoro import (
    FOREIGN,
    LANGUAGES,
    NATIVE,
    SPEEDS,
    KokoroPrompt,
    is_british,
)
from voice_assist.training.data.voices import Prompt, by_voice, espeak_variants, random_style

_SEED = 3
_NEAR, _TALK, _WORDS = 18, 6, 14  # texts of each voice
_MORE = 12  # texts of each voice that begin like a command, and amounts
_ACCENTED = 2  # accents of each native voice
_ACCENTED_NEAR = 3  # near words of each accent
_TAKES = 3  # voices of espeak-ng for each word of another language
_OWN = {"e": "Spanish", "f": "French", "j": "Japanese", "p": "Portuguese"}
_LATIN = ("de", "fr-fr", "es", "it", "pt-br", "nl", "cmn-latn-pinyin")  # written in letters


def plan_neural(sentences: Sequence[str]) -> list[KokoroPrompt]:
    """What each voice says, commands at every speed; the same in every run, for it takes long.

    Args:
        sentences: Of which some words are said.

    Raises:
        ModelError: espeak-ng, which knows the sounds, is not installed.
    """
    rng = Random(_SEED)
    near = [*texts.TWINS, *texts.TWINS, *texts.NEAR_MISSES, *texts.HARD]
    prompts: list[KokoroPrompt] = []
    for voice in (*NATIVE, *FOREIGN):
        for speed in SPEEDS:
            prompts += _said(texts.COMMANDS, voice, speed, "", "neural")
        own = [_OWN[voice[0]]] * 2 if voice in FOREIGN else rng.sample([*ACCENTS], _ACCENTED)
        for accent in own:
            speed = rng.choice(SPEEDS)
            prompts += _said(texts.COMMANDS, voice, speed, accent, "accent")
            some = rng.sample(texts.TWINS, _ACCENTED_NEAR)
            prompts += _said(some, voice, speed, accent, "accent near")
        if voice in NATIVE:
            some = rng.sample(near, _NEAR)
            prompts += _said(some, voice, rng.choice(SPEEDS), "", "neural near")
            spans = [texts.word_span(sentences, rng) for _ in range(_TALK)]
            prompts += _said(spans, voice, rng.choice(SPEEDS), "", "neural span")
        else:
            language = LANGUAGES[voice[0]]
            for word in rng.sample(texts.phrases(WORDS[language]), _WORDS):
                sounds = for_kokoro(ipa(word, language))
                prompts.append(KokoroPrompt(folded(word), sounds, voice, 1.0, "foreign"))
    return [prompt for prompt in prompts if prompt.text]


def plan_neural_texts() -> list[KokoroPrompt]:
    """What begins like a command, and amounts, in the natives' voices; the same in every run.

    Raises:
        ModelError: espeak-ng, which knows the sounds, is not installed.
    """
    rng = Random(_SEED)
    prompts: list[KokoroPrompt] = []
    for voice in NATIVE:
        for said, kind in ((texts.BEGINNINGS, "beginning"), (texts.AMOUNTS, "amount")):
            some = rng.sample(said, _MORE)
            prompts += _said(some, voice, rng.choice(SPEEDS), "", kind)
    return prompts


def plan_foreign(seed: int) -> list[Prompt]:
    """Words of other languages by espeak-ng's voices of those languages."""
    rng = Random(seed)
    variants, _ = espeak_variants()
    said = [
        Prompt(word, "espeak", f"{language}+{rng.choice(variants)}", *random_style(rng))
        for language in _LATIN
        for word in texts.phrases(WORDS[language])
        for _ in range(_TAKES)
    ]
    return sorted(said, key=by_voice)


def folded(word: str) -> str:
    """A word in the letters that the recogniser writes; other scripts give nothing."""
    letters = unicodedata.normalize("NFKD", word)
    return texts.normalise_text("".join(c for c in letters if c.isascii() and not c.isdigit()))


def _said(
    said: Sequence[str], voice: str, speed: float, accent: str, kind: str
) -> Iterator[KokoroPrompt]:
    british = is_british(voice)
    commands = {english(command, british=british, accent=accent) for command in texts.COMMANDS}
    for text in said:
        sounds = english(text, british=british, accent=accent)
        if text in texts.COMMANDS or sounds not in commands:
            yield KokoroPrompt(text, sounds, voice, speed, kind)

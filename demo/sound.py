# SPDX-License-Identifier: BSD-3-Clause
"""Speaks the script with espeak-ng over theatre noise, as one sound."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from demo.script import VOICES, Script, ScriptSpeech
from support.theatre_sound import LEVEL, RATE, speak, theatre_noise


def render(script: Script, lead: float = 0.0) -> NDArray[np.float32]:
    """Speak the whole script over noise.

    Args:
        script: What to say.
        lead: Noise alone before the script begins [s].

    Returns:
        Sound at 16 kHz in [-1, 1]. Shape (n,).

    Raises:
        RuntimeError: espeak-ng is missing or refuses a voice.
    """
    speech: ScriptSpeech = script.speech
    sound = theatre_noise(lead + script.duration, LEVEL * 10 ** (-speech.snr_db / 20), speech.seed)
    for step in script.steps:
        if step.speaker not in VOICES:
            continue
        voice = speech.surgeon if step.speaker == "surgeon" else speech.people
        words = speak(step.say, voice, speech.words_per_minute)
        first = int((lead + step.at) * RATE)
        piece = sound[first : first + len(words)]
        piece += words[: len(piece)]
    return np.clip(sound, -1.0, 1.0)

# SPDX-License-Identifier: BSD-3-Clause
"""What sounds like a command in a voice's accent, and so cannot be distinguished from it.

"pool more" is "pull more" in Scotland, and in the mouth of a voice whose language has one
such vowel. To train such a sound as no command teaches the network to refuse commands.
"""

from __future__ import annotations

import re
from functools import cache

from voice_assist.training.data import texts
from voice_assist.training.data.voices import Engine, phonemes, shared_phonemes

_UNHEARD = re.compile(r"[\s',;:_|\-0-9#%=!]")  # stress, length, breaks and shades of vowels


def same_as_command(text: str, engine: Engine, voice: str) -> bool:
    """Whether a text that is no command has the sounds of one in this voice.

    Args:
        text: Normalised.
        engine: Of the voice.
        voice: As Prompt has it.
    """
    if text in texts.COMMANDS:
        return False
    return sounds(text, engine, voice) in _commands(engine, _accent(engine, voice))


def sounds(text: str, engine: Engine, voice: str) -> str:
    """Sounds of a text in the accent of a voice, without stress and length."""
    return _sounds(text, engine, _accent(engine, voice))


def _accent(engine: Engine, voice: str) -> str:
    """The accent whose rules of pronunciation come nearest to the engine's."""
    return voice.partition("+")[0] if engine == "espeak" else "en-us"


@cache
def _commands(engine: Engine, accent: str) -> frozenset[str]:
    return frozenset(_sounds(command, engine, accent) for command in texts.COMMANDS)


@cache
def _sounds(text: str, engine: Engine, accent: str) -> str:
    said = phonemes(text, accent)
    return _UNHEARD.sub("", shared_phonemes(said) if engine == "phonemes" else said)

# SPDX-License-Identifier: BSD-3-Clause
"""Hear: from sound to a surgical command.

A name below is loaded when it is first used: importing the package alone loads no network.
`examples/` shows them at work.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from voice_assist.assembly import make_pipeline, make_recognizer
    from voice_assist.audio.sound_file import read_sound
    from voice_assist.audio.source import Framer
    from voice_assist.config import VoiceConfig, load_voice_config
    from voice_assist.errors import VoiceError
    from voice_assist.pipeline.pipeline import Pipeline
    from voice_assist.types import (
        Frame,
        Match,
        Mode,
        NoMatch,
        RejectionReason,
        UtteranceDecision,
    )

__all__ = [
    "Frame",
    "Framer",
    "Match",
    "Mode",
    "NoMatch",
    "Pipeline",
    "RejectionReason",
    "UtteranceDecision",
    "VoiceConfig",
    "VoiceError",
    "load_voice_config",
    "make_pipeline",
    "make_recognizer",
    "read_sound",
]

_HOMES = {
    "UtteranceDecision": "types",
    "Frame": "types",
    "Framer": "audio.source",
    "Match": "types",
    "Mode": "types",
    "NoMatch": "types",
    "Pipeline": "pipeline.pipeline",
    "RejectionReason": "types",
    "VoiceConfig": "config",
    "VoiceError": "errors",
    "load_voice_config": "config",
    "make_pipeline": "assembly",
    "make_recognizer": "assembly",
    "read_sound": "audio.sound_file",
}


def __getattr__(name: str) -> object:
    """Load a public name from its room."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)

# SPDX-License-Identifier: BSD-3-Clause
"""Builds the real parts that the settings name: recogniser, detector, source of sound."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from voice_assist.audio.microphone import Microphone, Pause
from voice_assist.audio.portaudio import PortAudio
from voice_assist.audio.source import Clock, Report, Source
from voice_assist.audio.wav_file import WavFile
from voice_assist.config import AudioConfig, VoiceConfig
from voice_assist.errors import AudioError
from voice_assist.pipeline import Pipeline
from voice_assist.vad.detector import make_detector

if TYPE_CHECKING:
    from voice_assist.recognizer.recognizer import Recognizer


def make_recognizer(config: VoiceConfig) -> Recognizer:
    """Load the recogniser, and limit torch to the threads of the settings.

    Raises:
        ModelError: The model is missing or damaged.
    """
    import torch

    from voice_assist.recognizer import load_recognizer

    torch.set_num_threads(config.recognizer.threads)
    return load_recognizer(config.recognizer.model, config.recognizer.device)


def make_pipeline(
    config: VoiceConfig, clock: Clock, recognizer: Recognizer | None = None
) -> Pipeline:
    """The pipeline with the real detector and, unless another is given, the real recogniser."""
    recognizer = recognizer or make_recognizer(config)
    return Pipeline(config, recognizer, make_detector(config.audio.vad), clock)


def make_source(config: AudioConfig, clock: Clock, pause: Pause, report: Report) -> Source:
    """Microphone or recording; an audio topic is built by the node.

    Args:
        config: Which one.
        clock: For the stamps [s].
        pause: Waits so many seconds; True: give up. `threading.Event.wait` does.
        report: Told what is wrong with the source; an empty text when all is well.
    """
    makers: dict[str, Callable[[], Source]] = {
        "microphone": lambda: Microphone(config.microphone, PortAudio(), clock, pause, report),
        "wav": lambda: WavFile(
            config.wav.path,
            clock,
            pause,
            speed=config.wav.speed,
            then_silence=config.wav.then == "silence",
        ),
    }
    if config.source not in makers:
        raise AudioError(f"source {config.source!r} exists only in the node; here: microphone, wav")
    return makers[config.source]()

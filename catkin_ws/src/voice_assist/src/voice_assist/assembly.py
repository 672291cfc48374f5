# SPDX-License-Identifier: BSD-3-Clause
"""Builds the real parts that the settings name: recogniser, detector, source of sound."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from hashlib import sha256
from typing import TYPE_CHECKING

from voice_assist.audio.capture.microphone import Microphone, Pause
from voice_assist.audio.capture.portaudio import PortAudio
from voice_assist.audio.source import AudioSource, Clock, Report
from voice_assist.audio.wav_file import WavFile
from voice_assist.config import AudioConfig, SpotterConfig, VoiceConfig
from voice_assist.errors import AudioError
from voice_assist.pipeline.pipeline import Pipeline
from voice_assist.pipeline.stop_decider import StopInSound
from voice_assist.side_inputs import Observer, ignore
from voice_assist.spotter.fusion import StopFusion
from voice_assist.vad.detector import make_detector

if TYPE_CHECKING:
    from voice_assist.recognizer.recognizer import Recognizer
    from voice_assist.speaker.gate import Gate
    from voice_assist.spotter.overlap import WindowNetwork
    from voice_assist.spotter.spotter import Spotter, Spotting

KERNEL_CACHE = "ONEDNN_PRIMITIVE_CACHE_CAPACITY"
MAX_KERNELS = 64  # 34 MB less after 20 minutes of talk and commands than 1,024, and no slower


def limit_torch(config: VoiceConfig) -> None:
    """Limit torch's threads to those of the settings, and the memory of its oneDNN.

    Each thread that computes must say it anew, for OpenMP keeps the limit per thread: one that has
    not set it starts a helper on every core, and they then wait for each other while the machine is
    busy. oneDNN compiles its code for each length of sound anew and keeps the newest 1,024. A limit
    in the environment stays.
    """
    os.environ.setdefault(KERNEL_CACHE, str(MAX_KERNELS))  # read when the first is compiled
    import torch

    torch.set_num_threads(config.recognizer.threads)


def make_recognizer(config: VoiceConfig) -> Recognizer:
    """Load the recogniser, with the profile in use, and limit torch's threads.

    Commands in another language than English are heard by the multilingual model, or by a profile
    that was enrolled in that language.

    Raises:
        ModelError: The model is missing or damaged.
        VoiceProfileError: The profile is missing, damaged, not active, or of another model or
            language.
    """
    from voice_assist.profile.active import personalise
    from voice_assist.recognizer import load_recognizer

    limit_torch(config)
    settings = config.recognizer
    if not config.is_multilingual:
        return personalise(
            config, load_recognizer(settings.model, settings.device, settings.precision)
        )
    from voice_assist.recognizer.checkpoint import EMBEDDED, MULTILINGUAL
    from voice_assist.recognizer.phrases import PhraseRecognizer
    from voice_assist.recognizer.whisper import load_multilingual

    model = MULTILINGUAL if settings.model == EMBEDDED else settings.model
    base = load_multilingual(model, settings.device, config.commands.language, settings.precision)
    return PhraseRecognizer(base, config.commands)


def precision_of(config: VoiceConfig) -> str:
    """Which precision the recogniser has, where the settings leave it to the device.

    Raises:
        ModelError: The device does not have the one that they ask for.
    """
    from voice_assist.recognizer.precision import dtype_for

    settings = config.recognizer
    return str(dtype_for(settings.device, settings.precision)).removeprefix("torch.")


def make_spotter(
    config: SpotterConfig, alone_in_motion: float | None = None
) -> tuple[Spotter, str]:
    """Load the spotter; gives the SHA-256 of its model too.

    Args:
        config: When it fires at rest.
        alone_in_motion: Score from which it fires in motion [nat]; None: as at rest.

    Raises:
        ModelError: The model or the networks below it are missing or damaged.
    """
    from voice_assist.spotter.features import Embedder
    from voice_assist.spotter.head import CONTEXT, read_head, scorer
    from voice_assist.spotter.spotter import Spotter

    head, digest = read_head()
    return Spotter(config, Embedder(), scorer(head), CONTEXT, alone_in_motion), digest


def make_spotters(config: VoiceConfig) -> tuple[Spotting, str]:
    """All spotters that the settings ask for, as one, and the SHA-256 of their models.

    Raises:
        ModelError: A model is missing or damaged.
    """
    moving = config.moving
    always, digest = make_spotter(config.spotter, moving.spotter_alone)
    if not (moving.is_enabled and config.spotter.over_talk):
        return always, digest
    from voice_assist.spotter.in_motion import SpotterInMotion
    from voice_assist.spotter.overlap import WindowCutter, overlap_scorer
    from voice_assist.spotter.spotter import Spotter

    network, digest_of_second = _over_talk(config.recognizer.precision)
    thresholds = replace(config.spotter, alone=moving.over_talk_alone)
    second = Spotter(thresholds, WindowCutter(), overlap_scorer(network), 1)
    both = sha256((digest + digest_of_second).encode()).hexdigest()
    return SpotterInMotion(always, second), both


@cache
def _over_talk(precision: str) -> tuple[WindowNetwork, str]:
    import torch

    from voice_assist.recognizer.precision import dtype_for, in_one_call, quick
    from voice_assist.spotter.overlap import WINDOW, read_overlap

    network, digest = read_overlap()
    dtype = dtype_for("cpu", precision)
    return in_one_call(quick(network, dtype), dtype, torch.zeros(1, WINDOW)), digest


def make_pipeline(
    config: VoiceConfig,
    clock: Clock,
    recognizer: Recognizer | None = None,
    spotting: Spotting | None = None,
    observer: Observer = ignore,
    voiceprint: bytes | None = None,
) -> Pipeline:
    """The pipeline with the real detector and, unless others are given, real networks.

    Args:
        config: All settings.
        clock: Stamps the frames [s].
        recognizer: One that is loaded already.
        spotting: A spotter that runs elsewhere; None: the pipeline runs its own, if it is enabled.
        observer: Gets all inputs other than sound.
        voiceprint: For the speaker gate; None: that of the profile in use, if it has one.

    Raises:
        ModelError: A network is missing or damaged.
        VoiceProfileError: The profile cannot be used.
    """
    from voice_assist.profile.active import with_profile

    recognizer = recognizer or make_recognizer(config)
    config, own = with_profile(config)
    voiceprint = voiceprint or own
    if spotting is None and config.spotter.is_enabled:
        spotting, _ = make_spotters(config)
    second, gate = StopFusion(config.spotter, spotting), _make_gate(config, voiceprint)
    detector = make_detector(config.audio.vad)
    in_sound = _stop_in_sound(config)
    return Pipeline(config, recognizer, detector, clock, second, observer, gate, in_sound)


def _stop_in_sound(config: VoiceConfig) -> StopInSound | None:
    if not (config.spotter.is_enabled and config.spotter.over_talk):
        return None
    from voice_assist.spotter.overlap import SoundScorer

    return SoundScorer(_over_talk(config.recognizer.precision)[0])


def _make_gate(config: VoiceConfig, voiceprint: bytes | None) -> Gate | None:
    if not config.speaker.is_on:
        return None  # nor is its network loaded
    from voice_assist.speaker.gate import make_gate

    return make_gate(config.speaker, voiceprint)


def make_source(config: AudioConfig, clock: Clock, pause: Pause, report: Report) -> AudioSource:
    """Microphone or recording; an audio topic is built by the node.

    Args:
        config: Which one.
        clock: For the stamps [s].
        pause: Waits so many seconds; True: give up. `threading.Event.wait` does.
        report: Gets what is wrong with the source; an empty text when all is well.

    Raises:
        AudioError: The source exists only in the node, or PortAudio is missing.
    """
    makers: dict[str, Callable[[], AudioSource]] = {
        "microphone": lambda: Microphone(config.microphone, PortAudio(), clock, pause, report),
        "wav": lambda: WavFile(
            config.wav.path,
            clock,
            pause,
            speed=config.wav.speed,
            then_silence=config.wav.after_end == "silence",
        ),
    }
    if config.source not in makers:
        raise AudioError(f"source {config.source!r} exists only in the node; here: microphone, wav")
    return makers[config.source]()

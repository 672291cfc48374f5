# SPDX-License-Identifier: BSD-3-Clause
"""Settings of the voice part, one YAML file for each of its sections, typed and checked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from typed_config import (
    choice,
    flag,
    integer,
    load_config,
    load_yaml,
    number,
    package_folder,
    require,
    text,
)
from voice_assist.config.calibration import Calibration
from voice_assist.config.commands import ENGLISH, LANGUAGES, NEVER_SURE, CommandsConfig
from voice_assist.config.moving import MovingConfig
from voice_assist.config.profile import ProfileConfig
from voice_assist.config.speaker import SpeakerConfig
from voice_assist.errors import CommandsError
from voice_assist.types import LONGEST

CONFIG_DIR = package_folder("voice_assist") / "config"
LOWEST_PITCH = 10.0  # [Hz] below it there is no sound to remove
LEAST_SPOKEN = 0.5  # [s] of a command that has to fit into an utterance
SLOWER = 5.0  # times that the multilingual model takes as long as the embedded one
PRECISIONS = ("auto", "bfloat16", "float32")
# Each a file and a key.
SECTIONS = ("audio", "recognizer", "spotter", "speaker", "profile", "commands", "moving")


@dataclass(frozen=True, kw_only=True)
class RobotSpeechConfig:
    """How long the robot's own speech is reckoned with."""

    RENAMED: ClassVar[Mapping[str, str]] = {
        "longest": "max_duration",
        "stop_confidence": "stop_over_speech_confidence",
    }
    max_duration: float = number(0.1, 600.0, "s")
    tail: float = number(0.0, 10.0, "s")
    window: float = number(0.0, 2.0, "s")
    stop_over_speech_confidence: float = number(0.0, 1.0, "")


@dataclass(frozen=True, kw_only=True)
class MicrophoneConfig:
    """Which microphone, and when it counts as lost."""

    is_whole: ClassVar[bool] = False  # `device` may be a part of its name, or empty
    device: str = text(may_be_empty=True)
    open_within: float = number(0.1, 60.0, "s")
    lost_after: float = number(0.2, 60.0, "s")
    retry_after: float = number(0.1, 60.0, "s")


class KeptMicrophoneConfig(MicrophoneConfig):
    """The one that a session had opened before: `device` is the whole of its name."""

    is_whole: ClassVar[bool] = True


@dataclass(frozen=True, kw_only=True)
class WavConfig:
    """A recording in place of a microphone."""

    RENAMED: ClassVar[Mapping[str, str]] = {"then": "after_end"}
    path: str = text(may_be_empty=True)
    speed: float = number(0.0, 1000.0, "times real time")
    after_end: str = choice("silence", "exit")


@dataclass(frozen=True, kw_only=True)
class TopicConfig:
    """An audio topic in place of a microphone."""

    name: str = text()
    lost_after: float = number(0.2, 60.0, "s")


@dataclass(frozen=True, kw_only=True)
class AudioDataConfig:
    """A topic of audio_common_msgs/AudioData in place of a microphone."""

    name: str = text()
    info: str = text(may_be_empty=True)
    rate: int = integer(8_000, 192_000, "Hz")
    channels: int = integer(1, 32)
    sample_format: str = choice("S16LE", "S32LE", "F32LE")
    lost_after: float = number(0.2, 60.0, "s")


@dataclass(frozen=True, kw_only=True)
class DenoiseConfig:
    """Noise reduction."""

    mode: str = choice("off", "endpointing_only", "on")
    high_pass: float = number(0.0, 1000.0, "Hz")
    reduction_db: float = number(0.0, 60.0, "dB")
    margin_db: float = number(0.0, 30.0, "dB")
    noise_rise: float = number(0.1, 60.0, "dB/s")

    def __post_init__(self) -> None:
        """Check what no key shows alone."""
        is_pitch = self.high_pass == 0.0 or self.high_pass >= LOWEST_PITCH
        allowed = f"0, which is no filter, or from {LOWEST_PITCH:g} Hz on"
        require(is_pitch, "high_pass", self.high_pass, allowed)


@dataclass(frozen=True, kw_only=True)
class VadConfig:
    """Where speech starts and ends."""

    detector: str = choice("silero", "energy", "either")
    start: float = number(0.01, 0.99, "")
    stop: float = number(0.01, 0.99, "")
    resume: float = number(0.01, 0.99, "")
    min_speech: float = number(0.0, 1.0, "s")
    hangover: float = number(0.05, 3.0, "s")
    pre_roll: float = number(0.0, 2.0, "s")
    max_utterance: float = number(1.0, 28.0, "s")
    energy_margin_db: float = number(3.0, 40.0, "dB")

    def __post_init__(self) -> None:
        """Check what no key shows alone."""
        require(self.stop <= self.resume, "stop", self.stop, f"up to resume, {self.resume:g}")
        least = round(self.pre_roll + self.min_speech + LEAST_SPOKEN, 6)
        allowed = f"from {least:g} s on: pre_roll, min_speech and {LEAST_SPOKEN:g} s of a command"
        require(self.max_utterance >= least, "max_utterance", self.max_utterance, allowed)


@dataclass(frozen=True, kw_only=True)
class AudioConfig:
    """Everything before recognition."""

    RENAMED: ClassVar[Mapping[str, str]] = {"talkback": "robot_speech"}
    source: str = choice("microphone", "wav", "topic", "audio_data")
    queue: int = integer(4, 100_000, "frames")
    deaf_after: float = number(0.1, 30.0, "s")
    microphone: MicrophoneConfig
    wav: WavConfig
    topic: TopicConfig
    audio_data: AudioDataConfig
    denoise: DenoiseConfig
    vad: VadConfig
    robot_speech: RobotSpeechConfig

    def __post_init__(self) -> None:
        """Check what no key shows alone."""
        is_named = self.source != "wav" or bool(self.wav.path.strip())
        require(is_named, "wav.path", self.wav.path, "a sound file, as source is wav")


@dataclass(frozen=True, kw_only=True)
class EarlyConfig:
    """When a decision may come before the end of the utterance is confirmed."""

    RENAMED: ClassVar[Mapping[str, str]] = {
        "shortest_rest": "min_rest",
        "stop_confidence": "first_stop_confidence",
    }
    is_enabled: bool = flag()
    partial_interval: float = number(0.032, 5.0, "s")
    settle: float = number(0.0, 2.0, "s")
    pause: float = number(0.03, 2.0, "s")
    silence_added: float = number(0.0, 2.0, "s")
    min_rest: float = number(0.0, 2.0, "s")
    unchanged_for: float = number(0.2, 10.0, "s")
    stop_agreement: int = integer(1, 10, "partials")
    vote_confidence: float = number(0.0, 1.0, "")
    first_stop_confidence: float = number(0.0, 1.0, "")
    window: float = number(1.0, 28.0, "s")
    noise_after: float = number(0.5, 28.0, "s")
    max_backlog: float = number(0.0, 10.0, "s")

    def __post_init__(self) -> None:
        """Check what no key shows alone."""
        require(self.settle < self.pause, "settle", self.settle, f"below pause, {self.pause:g} s")
        allowed = f"from vote_confidence on, {self.vote_confidence:g}"
        first = self.first_stop_confidence
        require(first >= self.vote_confidence, "first_stop_confidence", first, allowed)
        longest = round(LONGEST - self.silence_added, 6)
        allowed = f"up to {longest:g} s: a recogniser hears {LONGEST:g} s, with silence_added"
        require(self.window <= longest, "window", self.window, allowed)


@dataclass(frozen=True, kw_only=True)
class ConfidenceConfig:
    """What each kind of evidence is worth as a probability of being right."""

    transcript: Calibration
    scores: Calibration
    spotter: Calibration


@dataclass(frozen=True, kw_only=True)
class AskConfig:
    """When a motion that is nearly sure is asked for."""

    is_enabled: bool = flag()
    min_confidence: float = number(0.0, 1.0, "")
    min_verification: float = number(-1000.0, 1000.0, "nat")
    max_distance: float = number(0.0, 1.0, "")
    answer: str = text()
    answer_within: float = number(0.5, 10.0, "s")


@dataclass(frozen=True, kw_only=True)
class RecognizerConfig:
    """Recognition and the moment of decision."""

    RENAMED: ClassVar[Mapping[str, str]] = {"motion_glide": "motion_pitch_variation"}
    model: str = text()
    device: str = text()
    precision: str = choice(*PRECISIONS)
    threads: int = integer(1, 64, "threads")
    hung_after: float = number(0.1, 30.0, "s")
    second_opinion: bool = flag()
    motion_confidence: float = number(0.0, NEVER_SURE, "")
    motion_verification: float = number(-1000.0, 1000.0, "nat")
    motion_pitch_variation: float = number(0.0, 20.0, "cent")
    motion_speech: float = number(0.0, 0.99, "")
    confidence: ConfidenceConfig
    early: EarlyConfig
    ask: AskConfig


@dataclass(frozen=True, kw_only=True)
class SpotterConfig:
    """The second way to a stop, and how it agrees with the recogniser."""

    is_enabled: bool = flag()
    phrase: str = text()
    queue: int = integer(4, 10_000, "frames")
    patience: float = number(0.0, 1.0, "s")
    alone: float = number(-100.0, 1000.0, "nat")
    middle: float = number(-100.0, 1000.0, "nat")
    near: float = number(-1000.0, 1000.0, "nat")
    agree: float = number(-1000.0, 1000.0, "nat")
    agree_within: float = number(0.1, 5.0, "s")
    sure: float = number(0.0, 1.0, "")
    rearm_after: float = number(0.1, 60.0, "s")
    over_talk: bool = flag()
    over_talk_alone: float = number(-100.0, 1000.0, "nat")

    def __post_init__(self) -> None:
        """Check what no key shows alone."""
        allowed = f"up to middle, {self.middle:g} nat"
        require(self.agree <= self.middle, "agree", self.agree, allowed)


@dataclass(frozen=True, kw_only=True)
class VoiceConfig:
    """All settings of the voice part."""

    audio: AudioConfig
    recognizer: RecognizerConfig
    spotter: SpotterConfig
    speaker: SpeakerConfig
    profile: ProfileConfig
    commands: CommandsConfig
    moving: MovingConfig

    def __post_init__(self) -> None:
        """Check what no single file can show.

        Raises:
            CommandsError: What is spotted is no command that halts, or something is asked for that
                only English has.
        """
        language = self.commands.language
        if self.is_asking and language != ENGLISH:
            allowed = f"false with language {language}, where said_twice is false"
            raise CommandsError("recognizer.ask.is_enabled", True, allowed)
        halts = [c.phrase for c in self.commands.commands if c.is_halt]
        if self.spotter.is_enabled and self.spotter.phrase not in halts:
            allowed = ", ".join(halts) or "none"
            raise CommandsError("spotter.phrase", self.spotter.phrase, allowed)

    @property
    def is_asking(self) -> bool:
        """Whether a motion that is nearly sure is asked for; not where all are said twice."""
        return self.recognizer.ask.is_enabled and not self.commands.said_twice

    @property
    def is_multilingual(self) -> bool:
        """Whether the multilingual model hears the commands, and no profile of the language."""
        return self.commands.language != ENGLISH and not self.profile.is_used

    @property
    def hung_after(self) -> float:
        """Time on one frame after which recognition counts as hung [s]."""
        return self.recognizer.hung_after * (SLOWER if self.is_multilingual else 1.0)


def commands_file(folder: str | Path, language: str = ENGLISH) -> Path:
    """File of the commands in a language.

    Raises:
        ConfigError: There is no such language.
    """
    require(language in LANGUAGES, "language", language, ", ".join(LANGUAGES))
    return Path(folder) / ("commands.yaml" if language == ENGLISH else f"commands_{language}.yaml")


def section_files(folder: str | Path, language: str = ENGLISH) -> dict[str, Path]:
    """File of each section.

    Raises:
        ConfigError: There is no such language.
    """
    files = {name: Path(folder) / f"{name}.yaml" for name in SECTIONS}
    return files | {"commands": commands_file(folder, language)}


def load_voice_config(
    folder: str | Path = CONFIG_DIR, *, language: str = ENGLISH, **changes: Any
) -> VoiceConfig:
    """Read the YAML files of all sections.

    Args:
        folder: That holds them.
        language: Of the commands.
        **changes: Single settings to replace, by their path with `__` for dots, such as
            `audio__wav__speed=0.0`.

    Raises:
        typed_config.ConfigError: A file or a key is not as it must be.
        CommandsError: The commands contradict each other.
    """
    files = section_files(folder, language)
    data = {name: dict(load_yaml(file)) for name, file in files.items()}
    for path, value in changes.items():
        *parents, key = path.split("__")
        branch: dict[str, Any] = data
        for parent in parents:
            branch = branch[parent]
        branch[key] = value
    return voice_config(data)


def voice_config(data: Mapping[str, Any]) -> VoiceConfig:
    """Build the settings from a mapping, as the parameter server gives it."""
    return load_config(VoiceConfig, data)

# SPDX-License-Identifier: BSD-3-Clause
"""Settings: one frozen dataclass per YAML file."""

from voice_assist.config.commands import CommandConfig, CommandsConfig
from voice_assist.config.moving import MovingConfig
from voice_assist.config.voice import (
    CONFIG_DIR,
    SECTIONS,
    AudioConfig,
    DenoiseConfig,
    EarlyConfig,
    KeptMicrophoneConfig,
    MicrophoneConfig,
    SpotterConfig,
    TopicConfig,
    VadConfig,
    VoiceConfig,
    load_voice_config,
    voice_config,
)

__all__ = [
    "CONFIG_DIR",
    "SECTIONS",
    "AudioConfig",
    "CommandConfig",
    "CommandsConfig",
    "DenoiseConfig",
    "EarlyConfig",
    "KeptMicrophoneConfig",
    "MicrophoneConfig",
    "MovingConfig",
    "SpotterConfig",
    "TopicConfig",
    "VadConfig",
    "VoiceConfig",
    "load_voice_config",
    "voice_config",
]

# SPDX-License-Identifier: BSD-3-Clause
"""Settings of the alarms, from `config/alarms.yaml`."""

from __future__ import annotations

from dataclasses import dataclass

from typed_config import choice, flag, number, text
from voice_assist.config.voice import CONFIG_DIR

FILE = CONFIG_DIR / "alarms.yaml"


@dataclass(frozen=True, kw_only=True)
class SoundConfig:
    """How alarms sound."""

    is_enabled: bool = flag()
    device: str = text(may_be_empty=True)
    volume_db: float = number(-60.0, 0.0, "dB")
    notices: bool = flag()
    repeat_high: float = number(2.5, 15.0, "s")
    repeat_medium: float = number(2.5, 30.0, "s")
    refusal_apart: float = number(0.0, 60.0, "s")
    stuck_after: float = number(0.2, 30.0, "s")


@dataclass(frozen=True, kw_only=True)
class SpeechConfig:
    """Spoken answers."""

    is_enabled: bool = flag()
    synthesizer: str = choice("espeak-ng", "kokoro")
    voice: str = text()
    words_per_minute: float = number(80.0, 450.0, "")
    kokoro_styles: str = text(may_be_empty=True)
    volume_db: float = number(-60.0, 0.0, "dB")
    in_motion: bool = flag()
    quiet_after_stop: float = number(0.5, 60.0, "s")


@dataclass(frozen=True, kw_only=True)
class BoardConfig:
    """How long things stand, and when silence is a fault."""

    shown_for: float = number(0.5, 60.0, "s")
    starting_for: float = number(0.0, 300.0, "s")
    controller_silent_after: float = number(0.1, 30.0, "s")
    voice_silent_after: float = number(1.5, 60.0, "s")
    pedal_silent_after: float = number(1.5, 60.0, "s")
    devices_silent_after: float = number(1.5, 60.0, "s")


@dataclass(frozen=True, kw_only=True)
class AlarmMarkerConfig:
    """Where a viewer shows the line."""

    frame: str = text()
    place: tuple[float, float, float] = number(-10.0, 10.0, "m")
    letter: float = number(0.001, 1.0, "m")


@dataclass(frozen=True, kw_only=True)
class AlarmsConfig:
    """All settings of the alarms."""

    sound: SoundConfig
    speech: SpeechConfig
    board: BoardConfig
    look: AlarmMarkerConfig

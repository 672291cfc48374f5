# SPDX-License-Identifier: BSD-3-Clause
"""Settings of the experiment, and the choice of voices."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from typed_config import (
    ConfigError,
    choice,
    flag,
    integer,
    items,
    load_file,
    number,
    text,
)

FILE = Path(__file__).resolve().parent / "experiment.yaml"


@dataclass(frozen=True, kw_only=True)
class PaperVoiceConfig:
    """One synthetic speaker."""

    name: str = text()
    engine: str = choice("espeak", "phonemes", "flite", "festival", "rhvoice", "pico", "mbrola")
    voice: str = text()  # as the engine calls it
    accent: str = text()
    is_native: bool = flag()


@dataclass(frozen=True, kw_only=True)
class ExperimentConfig:
    """experiment.yaml: who says what how often, and what is waited for."""

    repetitions: int = integer(1, 1000)
    talk_share: float = number(0.0, 0.9, "")
    seed: int = integer(0, 2**31 - 1)
    snr_db: float = number(-10.0, 60.0, "dB")
    rate: tuple[float, float] = number(0.5, 2.0, "")
    pitch: tuple[float, float] = number(0.0, 1.0, "")
    pause: tuple[float, float] = number(0.0, 10.0, "s")
    into_motion: tuple[float, float] = number(0.0, 10.0, "s")
    decide_within: float = number(0.1, 10.0, "s")
    answer_within: float = number(0.1, 10.0, "s")
    rest_within: float = number(1.0, 120.0, "s")
    voices: tuple[PaperVoiceConfig, ...] = items(1, 50)
    prompter: PaperVoiceConfig
    talk: tuple[str, ...] = text()

    def __post_init__(self) -> None:
        """Check what no key shows alone."""
        names = [voice.name for voice in self.voices]
        if len(set(names)) < len(names):
            raise ConfigError("voices", names, "names that differ")
        for key in ("rate", "pitch", "pause", "into_motion"):
            low, high = getattr(self, key)
            if low > high:
                raise ConfigError(key, (low, high), "the smaller number first")


def load_experiment(path: Path = FILE) -> ExperimentConfig:
    """Read the settings.

    Raises:
        ConfigError: A key is wrong.
    """
    return load_file(ExperimentConfig, path)


def chosen_voices(
    config: ExperimentConfig, wanted: str, installed: frozenset[str]
) -> tuple[PaperVoiceConfig, ...]:
    """Choose the speakers.

    Args:
        config: Settings.
        wanted: How many, or names with commas between.
        installed: Names of the voices whose programs and data are there.

    Raises:
        ConfigError: There is no such voice, it is not installed, or there are not so many.
    """
    present = tuple(voice for voice in config.voices if voice.name in installed)
    if wanted.isdigit():
        if not 1 <= int(wanted) <= len(present):
            raise ConfigError("VOICES", wanted, f"a number from 1 to {len(present)}")
        return present[: int(wanted)]
    by_name = {voice.name: voice for voice in present}
    names = [name.strip() for name in wanted.split(",")]
    for name in names:
        if name not in by_name:
            raise ConfigError("VOICES", name, f"of those installed: {', '.join(by_name)}")
    return tuple(by_name[name] for name in dict.fromkeys(names))

# SPDX-License-Identifier: BSD-3-Clause
"""Settings of enrolment; config/enrolment.yaml explains each key."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from typed_config import integer, load_file, number, text
from voice_assist.config.voice import CONFIG_DIR


@dataclass(frozen=True, kw_only=True)
class CheckConfig:
    """What a take must be like."""

    RENAMED: ClassVar[Mapping[str, str]] = {
        "quietest": "min_level",
        "clipped": "max_clipped",
        "least_snr": "min_snr",
        "shortest": "min_length",
        "longest": "max_length",
        "least_talk": "min_talk",
    }

    min_level: float = number(-90.0, 0.0, "dB")
    max_clipped: float = number(0.0, 0.1, "")
    edge: float = number(0.0, 1.0, "s")
    min_snr: float = number(0.0, 60.0, "dB")
    min_length: float = number(0.01, 5.0, "s")
    max_length: float = number(0.1, 10.0, "s")
    min_talk: float = number(0.0, 1.0, "")
    other_by: float = number(0.0, 1000.0, "nat")
    unlike_by: float = number(0.0, 1000.0, "nat")


@dataclass(frozen=True, kw_only=True)
class AdaptConfig:
    """How the recogniser learns a voice."""

    frozen_blocks: int = integer(0, 64)
    copies: int = integer(1, 100)
    broken_off: int = integer(0, 100)
    others: int = integer(0, 5000)
    own_share: float = number(0.05, 1.0, "")
    batch: int = integer(2, 256)
    steps: int = integer(1, 10_000)
    rate: float = number(0.0, 0.1, "")
    seed: int = integer(0, 1_000_000)


@dataclass(frozen=True, kw_only=True)
class SelfCheckConfig:
    """When a profile is fit to be used."""

    folds: int = integer(2, 10)
    others: int = integer(12, 5000)
    talk_more: int = integer(0, 100)
    own_worse: int = integer(0, 100)
    own_confused: int = integer(0, 100)
    others_worse: float = number(0.0, 0.2, "")
    others_taken: float = number(0.0, 0.2, "")
    margin: float = number(0.0, 0.5, "")


@dataclass(frozen=True, kw_only=True)
class EnrolmentConfig:
    """What is asked of the person, and how it is learned from."""

    repetitions: int = integer(3, 10)
    talk: float = number(0.0, 600.0, "s")
    room: float = number(0.5, 60.0, "s")
    take: float = number(1.0, 10.0, "s")
    talk_piece: float = number(2.0, 60.0, "s")
    session_reader: str = text()
    checks: CheckConfig
    adapt: AdaptConfig
    self_check: SelfCheckConfig


def load_enrolment_config(folder: str | Path = CONFIG_DIR) -> EnrolmentConfig:
    """Read enrolment.yaml.

    Raises:
        typed_config.ConfigError: The file or a key is not as it must be.
    """
    return load_file(EnrolmentConfig, Path(folder) / "enrolment.yaml")

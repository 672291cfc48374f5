# SPDX-License-Identifier: BSD-3-Clause
"""Settings of the operator's page, from `config/display.yaml`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from typed_config import integer, load_config, load_yaml, number, text
from voice_assist.config.voice import CONFIG_DIR

FILE = "display.yaml"


@dataclass(frozen=True, kw_only=True)
class PictureConfig:
    """Where the picture of the scene comes from."""

    topic: str = text()
    request: str = text(may_be_empty=True)
    camera_info: str = text()
    camera_pose: str = text()
    period: float = number(0.1, 60.0, "s")
    share: float = number(0.01, 1.0, "")


@dataclass(frozen=True, kw_only=True)
class DisplayConfig:
    """All settings of the page."""

    address: str = text()
    port: int = integer(0, 65_535)
    hosts: tuple[str, ...] = text()
    rate: float = number(1.0, 30.0, "Hz")
    old_after: float = number(0.1, 10.0, "s")
    max_viewers: int = integer(1, 1000)
    backlog: int = integer(2, 1000)
    picture: PictureConfig


def load_display_config(folder: str | Path = CONFIG_DIR) -> DisplayConfig:
    """Read `display.yaml` of a folder.

    Raises:
        typed_config.ConfigError: The file or a key is not as it must be.
    """
    return display_config(load_yaml(Path(folder) / FILE))


def display_config(data: Mapping[str, Any]) -> DisplayConfig:
    """Build the settings from a mapping, as the parameter server gives it."""
    return load_config(DisplayConfig, data, FILE)

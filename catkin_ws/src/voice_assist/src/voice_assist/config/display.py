# SPDX-License-Identifier: BSD-3-Clause
"""Settings of the operator's page, from `config/display.yaml`."""

from __future__ import annotations

from dataclasses import dataclass

from typed_config import choice, integer, number, text
from voice_assist.config.commands import LANGUAGES
from voice_assist.config.voice import CONFIG_DIR

FILE = CONFIG_DIR / "display.yaml"


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
    language: str = choice(*LANGUAGES)
    picture: PictureConfig

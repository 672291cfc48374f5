# SPDX-License-Identifier: BSD-3-Clause
"""believed.yaml: nodes whose messages count for voice, pedals, devices, alarms and page."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any, Final

from typed_config import load_config, load_yaml, text
from typed_config.node_names import require_names
from voice_assist.config.voice import CONFIG_DIR

FILE: Final = "believed.yaml"


@dataclass(frozen=True, kw_only=True)
class VoiceBelievedConfig:
    """Names of nodes by what they publish; [] stands for anybody."""

    controller: tuple[str, ...] = text()
    voice: tuple[str, ...] = text()
    pedal: tuple[str, ...] = text()
    joy: tuple[str, ...] = text()
    audio: tuple[str, ...] = text()
    speaker: tuple[str, ...] = text()
    camera: tuple[str, ...] = text()
    system: tuple[str, ...] = text()

    def __post_init__(self) -> None:
        """Check what no key shows alone."""
        for field in fields(self):
            require_names(field.name, getattr(self, field.name))


def believed_config(given: Mapping[str, Any] | None) -> VoiceBelievedConfig:
    """Settings of a node.

    Args:
        given: As the parameter server has them; None: those of the package's file.

    Raises:
        typed_config.ConfigError: A key is unknown, missing or no list of names.
    """
    return load_config(
        VoiceBelievedConfig, load_yaml(CONFIG_DIR / FILE) if given is None else given, FILE
    )

# SPDX-License-Identifier: BSD-3-Clause
"""speaker.yaml: whether a command's voice is checked, and how strictly."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from typed_config import choice, number

OFF, ON = "off", "on"


@dataclass(frozen=True, kw_only=True)
class SpeakerConfig:
    """The speaker gate."""

    RENAMED: ClassVar[Mapping[str, str]] = {
        "most_missed": "max_missed",
        "least_speech": "min_speech",
        "least_enrolled": "min_enrolled",
    }
    gate: str = choice(OFF, ON)
    false_accept: float = number(0.0005, 0.2, "")
    max_missed: float = number(0.0, 0.5, "")
    min_speech: float = number(0.1, 2.0, "s")
    min_enrolled: float = number(2.0, 600.0, "s")

    @property
    def is_on(self) -> bool:
        """Motion commands are checked."""
        return self.gate == ON

# SPDX-License-Identifier: BSD-3-Clause
"""Settings of looking about: the steps of an endoscope under the trocar."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from typed_config import number


@dataclass(frozen=True, kw_only=True)
class CameraStepConfig:
    """How far one step goes, and how the camera sits on the tool."""

    RENAMED: ClassVar[Mapping[str, str]] = {"most_tilt": "max_tilt"}

    angle: float = number(0.001, 0.5, "rad")
    depth: float = number(0.0005, 0.05, "m")
    image_roll: float = number(-3.1416, 3.1416, "rad")
    max_tilt: float = number(0.05, 1.5, "rad")

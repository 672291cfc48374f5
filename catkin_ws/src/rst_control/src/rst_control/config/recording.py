# SPDX-License-Identifier: BSD-3-Clause
"""The part of controller.yaml that says what the robot does where nothing records it."""

from __future__ import annotations

from dataclasses import dataclass

from typed_config import choice, number

IGNORE, REFUSE, STOP = "ignore", "refuse", "stop"


@dataclass(frozen=True, kw_only=True)
class RecordingConfig:
    """What a lost recording means for the robot, and when it counts as lost."""

    on_loss: str = choice(IGNORE, REFUSE, STOP)
    heartbeat_age: float = number(0.2, 60.0, "s")

# SPDX-License-Identifier: BSD-3-Clause
"""moving.yaml: how a "stop" is heard while the robot moves."""

from __future__ import annotations

from dataclasses import dataclass

from typed_config import flag, integer, number


@dataclass(frozen=True, kw_only=True)
class MovingConfig:
    """When the robot counts as moving, and the thresholds of a "stop" then."""

    is_enabled: bool = flag()
    state_age: float = number(0.1, 10.0, "s")
    settle: float = number(0.1, 10.0, "s")
    spotter_alone: float = number(-100.0, 1000.0, "nat")
    sentence_confidence: float = number(0.0, 1.0, "")
    sentence_agreement: int = integer(1, 10, "transcripts")
    window: float = number(0.0, 4.0, "s")
    nearly_said: float = number(-1000.0, 1000.0, "nat")
    over_talk_alone: float = number(-100.0, 1000.0, "nat")
    over_talk_agree: float = number(-100.0, 1000.0, "nat")
    refuse_spotter: float = number(-100.0, 1000.0, "nat")
    refuse_over_talk: float = number(-100.0, 1000.0, "nat")

# SPDX-License-Identifier: BSD-3-Clause
"""The part of controller.yaml that says which measurements are believed."""

from __future__ import annotations

from dataclasses import dataclass

from typed_config import number


@dataclass(frozen=True, kw_only=True)
class SensorConfig:
    """What a working sensor never says; each is explained in controller.yaml."""

    jump: float = number(1e-4, 0.05, "rad")
    late: float = number(0.0, 0.1, "s")
    velocity_error: float = number(1e-4, 0.05, "rad")
    velocity_lag: float = number(0.0, 0.2, "s")
    frozen_way: float = number(1e-4, 0.05, "rad")
    frozen_after: float = number(0.005, 0.25, "s")
    tension_age: float = number(0.004, 0.2, "s")
    tension_jump: float = number(0.05, 2.4, "N")
    tension_deficit: float = number(0.05, 2.4, "N")
    tension_zero: float = number(0.01, 1.0, "N")
    tension_frozen_way: float = number(1e-4, 0.005, "m")
    slack_way: float = number(1e-4, 0.03, "m")
    plausible_for: float = number(0.01, 0.25, "s")

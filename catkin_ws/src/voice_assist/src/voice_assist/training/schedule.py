# SPDX-License-Identifier: BSD-3-Clause
"""The learning rate: warm-up, a plateau, and a linear way down."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Schedule:
    """Learning rate by step."""

    steps: int  # of the whole run
    peak: float = 1.5e-3
    warm_up: int = 300  # steps
    decay: float = 0.35  # share of the steps spent on the way down

    def rate(self, step: int) -> float:
        """Learning rate of a step, never quite zero."""
        rising = min((step + 1) / self.warm_up, 1.0)
        left = (self.steps - step) / max(self.decay * self.steps, 1)
        return self.peak * min(rising, max(left, 0.01), 1.0)

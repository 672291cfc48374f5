# SPDX-License-Identifier: BSD-3-Clause
"""From evidence in nats to the probability of being right."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from typed_config import number

_FARTHEST = 700.0  # [nat] beyond it exp overflows


@dataclass(frozen=True, kw_only=True)
class Calibration:
    """A logistic curve, as Platt (1999) fits it to right and wrong claims, level at its end.

    Level, because evidence weighs a claim against what the network can distinguish from it. Of two
    phrases that sound the same, the wrong one has as much evidence as the right one.
    """

    RENAMED: ClassVar[Mapping[str, str]] = {"most": "max_evidence"}
    slope: float = number(0.001, 1000.0, "1/nat")
    offset: float = number(-100.0, 100.0, "")
    max_evidence: float = number(-1000.0, 1000.0, "nat")

    def __call__(self, evidence: float) -> float:
        """Probability of being right, [0, 1]; rises with the evidence up to `max_evidence`.

        Args:
            evidence: For the claim rather than against it [nat]; may be infinite.
        """
        return logistic(self.slope * min(evidence, self.max_evidence) + self.offset)


def logistic(x: float) -> float:
    """Probability of log-odds."""
    return 1.0 / (1.0 + math.exp(-min(max(x, -_FARTHEST), _FARTHEST)))


def log_odds(probability: float) -> float:
    """Inverse of logistic; finite, as the probabilities 0 and 1 are met by rounding only."""
    inside = min(max(probability, 1e-12), 1.0 - 1e-12)
    return math.log(inside / (1.0 - inside))

# SPDX-License-Identifier: BSD-3-Clause
"""As `plant.py`, for an arm that is led by velocities through Kinova's simulated drivers."""

from __future__ import annotations

from bench.site.plant import measured
from support.figures import Figure


def measure() -> list[Figure]:
    """Figures of an arm that is led by velocities."""
    return measured("velocities")

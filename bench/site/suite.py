# SPDX-License-Identifier: BSD-3-Clause
"""Figures of what a site does; `make bench ONLY=site.tension` measures one part.

`make bench ONLY=site` measures none: it gathers what was measured last into one file.
"""

from __future__ import annotations

from collections.abc import Callable

from bench.safety.suite import gather
from bench.site import mounting, near_limits, stops, tension, turns
from support.figures import RESULTS, Figure

PARTS: dict[str, Callable[[], list[Figure]]] = {
    "tension": tension.measure,  # a sensor that fails in each way, while tissue is held
    "near_limits": near_limits.measure,  # inverse kinematics where joints are near their ends
    "turns": turns.measure,  # joints that turn for ever, written in each of their turns
    "mounting": mounting.measure,  # a base on a wall, aslant or on the ceiling
    "stops": stops.measure,  # feedback, driver, bridge or its host lost in motion
}


def measure() -> list[Figure]:
    """What was last measured of all parts, each with its date, code and load."""
    return gather(RESULTS / "site", tuple(PARTS))

# SPDX-License-Identifier: BSD-3-Clause
"""Tension control alone on tissue that no lattice shows: slack, exponential, suddenly stiffer.

The tension follows from the displacement by a formula, and reaches the controller as late as in
the simulation, with noise and one sample later still.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from rst_control.config import ControllerConfig
from rst_control.tension.control import TensionControl
from rst_control.trajectory.motion_profile import MotionBounds
from rst_control.types import PathState
from support.figures import Figure

Law = Callable[[float], float]  # tension [N] at a displacement [m]

RANGE = (80.0, 4000.0)  # [N/m]
TARGETS = (0.3, 2.0)  # [N]
BENDS = (100.0, 1000.0)  # [1/m] of exponential tissue
SLACK = 0.005  # [m] at most
STIFFER = 10.0  # times, at a random tension on the way to the target
STIFFENED = math.log(RANGE[1] / RANGE[0] / STIFFER) / math.log(RANGE[1] / RANGE[0])
NOISE = 0.005  # [N] rms
BRAKING = 1.2  # [m/s^2] as the joints allow on the pull path of the scene
LENGTH, LONGEST = 0.2, 20.0  # [m] of the path and [s] of a pull
TOLERANCE = 0.02  # [N]


@dataclass(frozen=True)
class PullOutcome:
    """One pull from zero."""

    target: float  # [N]
    peak: float  # [N]
    error: float  # [N] at the end
    beyond: float  # [s] from loaded to settled, less the travel at full speed


def measure(config: ControllerConfig, pulls: int) -> list[Figure]:
    """First pulls of tissue of random stiffness and targets, a quarter of them of each law.

    Args:
        config: Settings of the controller.
        pulls: Number of pulls.
    """
    rng, figures = np.random.default_rng(77), list[Figure]()
    for name, draw in (
        ("slack", slack),
        ("exponential", exponential),
        ("tenfold stiffening", stiffening),
        ("tenfold stiffening, up to 40,000 N/m,", stiffening_to_bone),
    ):
        outcomes = []
        for _ in range(max(1, pulls // 4)):
            target = float(rng.uniform(*TARGETS))
            outcomes.append(pull(config, draw(rng, target), target, rng))
        is_sudden = draw in (stiffening, stiffening_to_bone)
        figures += _figures(f"tension of {name} tissue", outcomes, is_sudden)
    return figures


def slack(rng: np.random.Generator, target: float) -> Law:
    """Tissue that is taut only after a way."""
    stiffness, start = _stiffness(rng), float(rng.uniform(0.0, SLACK))
    return lambda s: stiffness * max(0.0, s - start)


def exponential(rng: np.random.Generator, target: float) -> Law:
    """Tissue after Fung: F = a (exp(b s) - 1), as stiff as drawn when it has its target."""
    bend = float(np.exp(rng.uniform(*np.log(BENDS))))
    stiffness = max(_stiffness(rng), 1.1 * bend * target)
    a = stiffness / bend - target
    return lambda s: a * math.expm1(min(bend * max(0.0, s), 50.0))


def stiffening(rng: np.random.Generator, target: float) -> Law:
    """Tissue that is ten times as stiff beyond a random share of the target, within the range."""
    return _stiffer(RANGE[0] * (_stiffness(rng) / RANGE[0]) ** STIFFENED, target, rng)


def stiffening_to_bone(rng: np.random.Generator, target: float) -> Law:
    """The same from anywhere in the range, so that it ends far above it."""
    return _stiffer(_stiffness(rng), target, rng)


def _stiffer(stiffness: float, target: float, rng: np.random.Generator) -> Law:
    bend = float(rng.uniform(0.1, 0.98)) * target
    return lambda s: stiffness * max(0.0, s) + (STIFFER - 1.0) * max(0.0, stiffness * s - bend)


def pull(
    config: ControllerConfig, law: Law, target: float, rng: np.random.Generator
) -> PullOutcome:
    """Pull from zero until it rests."""
    speed, dt = config.speed, 1.0 / config.rate
    bounds = MotionBounds(speed.pull_speed, speed.acceleration, speed.jerk)
    brakes = MotionBounds(speed.pull_speed, BRAKING, speed.braking_jerk)
    control = TensionControl(config.tension, bounds, brakes, LENGTH, PathState(0.0), target)
    late = round(config.tension.delay / dt) + 1
    seen, forces, places = deque([0.0] * late), list[float](), list[float]()
    while len(forces) < LONGEST / dt and not (control.is_settled or control.is_at_limit):
        state = control.step(abs(seen.popleft() + rng.normal(0.0, NOISE)), dt)
        forces.append(law(state.s))
        places.append(state.s)
        seen.append(forces[-1])
    force = np.array(forces)
    loaded = int(np.argmax(force > TOLERANCE))
    outside = np.flatnonzero(np.abs(force - target) > TOLERANCE)
    travel = (places[-1] - places[loaded]) / speed.pull_speed
    beyond = float((outside[-1] - loaded) * dt) - travel
    return PullOutcome(target, float(force.max()), float(abs(force[-1] - target)), beyond)


def _stiffness(rng: np.random.Generator) -> float:
    return float(np.exp(rng.uniform(*np.log(RANGE))))


def _figures(name: str, outcomes: list[PullOutcome], is_sudden: bool) -> list[Figure]:
    overshoot = 100.0 * max(o.peak / o.target - 1.0 for o in outcomes)
    note = f"({len(outcomes)} first pulls with a noisy late sensor)"
    target = None if is_sudden else 5.0
    return [
        Figure(f"{name}: peak", max(o.peak for o in outcomes), "N", 2.4, note=note),
        Figure(f"{name}: overshoot max", max(0.0, overshoot), "%", target),
        Figure(f"{name}: error at the end, max", max(o.error for o in outcomes), "N", 0.02),
        Figure(
            f"{name}: settled beyond the travel, max", max(o.beyond for o in outcomes), "s", 0.5
        ),
    ]

# SPDX-License-Identifier: BSD-3-Clause
"""Item 6: a stop at a random moment of a motion; how long, how far, how well along the trocar.

Time and way count from the moment when the controller hears of the stop until the simulated joints
rest. Where the joints could not stop soon enough from the speed asked for, the controller goes
slower: the notes give the speeds at which stops truly began.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bench.common.rig import Rig, with_layer, with_speed
from rst_control.config import MotionConfig, SimulationConfig
from rst_control.planning.plan import Phase
from rst_control.types import Cause, Reason
from support.figures import Figure

SPEEDS = (0.020, 0.050)  # [m/s] of the tip, asked for
REST = 2e-4  # [rad/s] joints slower than this are at rest
MIN_LENGTH = 0.02  # [m] of a path
Targets = tuple[float | None, float | None]
TARGETS: dict[str, Targets] = {"hard": (60.0, 0.6), "driver_soft": (None, 2.6)}  # [ms] and [mm]


@dataclass(frozen=True)
class BrakedStop:
    """One braking."""

    speed: float  # [m/s] of the tip when the stop comes
    time: float  # [s] from there until the joints rest
    distance: float  # [m] that the tip still went
    rcm_error: float  # [m] largest while braking


def measure(config: MotionConfig, simulation: SimulationConfig, stops: int) -> list[Figure]:
    """Stops of random paths in the 1 kHz simulation, given at random moments.

    Args:
        config: Settings of the controller.
        simulation: Settings of the simulated robot.
        stops: For each speed and layer of limits.
    """
    figures: list[Figure] = []
    for speed in SPEEDS:
        faster = with_speed(config, tip_speed=speed)
        for layer in ("hard", "driver_soft"):
            with Rig(with_layer(faster, layer), simulation) as rig:
                name = f"braking, {speed * 1e3:.0f} mm/s asked, {layer} limits"
                figures += _figures(name, TARGETS[layer], _stops(rig, stops))
    return figures


def _figures(name: str, targets: Targets, stops: list[BrakedStop]) -> list[Figure]:
    time, distance = targets
    speeds = [s.speed * 1e3 for s in stops]
    note = f"({len(stops)} stops, the tip at {min(speeds):.1f} to {max(speeds):.1f} mm/s)"
    worst = [max(s.time for s in stops), max(s.distance for s in stops)]
    rcm = max(s.rcm_error for s in stops)
    median = float(np.median([s.time for s in stops]))
    return [
        Figure(f"{name}: time max", worst[0] * 1e3, "ms", time, note=note),
        Figure(f"{name}: time median", median * 1e3, "ms"),
        Figure(f"{name}: distance max", worst[1] * 1e3, "mm", distance),
        Figure(f"{name}: RCM error max", rcm * 1e6, "um", 10.0),
    ]


def _stops(rig: Rig, count: int) -> list[BrakedStop]:
    """Set off along random paths and stop each at a random moment."""
    rng, stops = np.random.default_rng(6), []
    rig.wake()
    for path in rig.ways(20 * count, seed=6, min_length=MIN_LENGTH):
        phase = rig.set_off(path)
        duration = path.length / phase.speed
        rig.run(float(rng.uniform(0.05, 0.95)) * duration)
        if rig.is_moving:
            stops.append(_stop(rig, phase))
        rig.until(lambda: not rig.is_moving)
        rig.run(0.05)
        rig.give("hey robot")
        if len(stops) == count:
            break
    return stops


def _stop(rig: Rig, phase: Phase) -> BrakedStop:
    rcm: list[float] = []
    before = rig.tip
    rig.run(rig.period)
    speed = float(np.linalg.norm(rig.tip - before)) / rig.period
    received, start, still = rig.robot.now, rig.tip, [rig.robot.now]

    def observe() -> None:
        rcm.append(rig.rcm_error)
        if np.abs(rig.robot.reading.velocity).max() > REST:
            still[0] = rig.robot.now

    rig.executor.stop(Cause(Reason.STOP_TOPIC, "bench"))
    while rig.robot.now < received + 1.5 and (rig.is_moving or rig.robot.now < still[0] + 0.02):
        rig.tick(observe)
    return BrakedStop(speed, still[0] - received, float(np.linalg.norm(rig.tip - start)), max(rcm))

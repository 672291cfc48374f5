# SPDX-License-Identifier: BSD-3-Clause
"""Item 6: a stop at a random moment of a motion; how long, how far, how well along the trocar.

Time and way count from the moment when the controller hears of the stop until the simulated joints
rest. Where the joints could not stop soon enough from the speed asked for, the controller goes
slower: the speeds that stops truly began at are told, too. From truly 50 mm/s a stop takes longer
on nearly every path: the last figure says at how many places the joints' own acceleration limits
leave any braking law a chance.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bench.common.rig import Rig, random_poses, with_layer, with_speed
from rst_control.commands.request import Plan
from rst_control.commands.table import COMMANDS
from rst_control.config import MotionConfig, SimulationConfig
from rst_control.errors import Infeasible
from rst_control.execution.orders import Order
from rst_control.kinematics.robot_model import load_robot
from rst_control.planning.plan import Phase, PhaseKind
from rst_control.planning.planner import Planner
from rst_control.trajectory.path import Path
from rst_control.types import Cause, Reason
from support.figures import Figure

FAST = 0.050  # [m/s]
REST = 2e-4  # [rad/s] joints slower than this are at rest
LEAST_LENGTH = 0.02  # [m] of a path
Targets = tuple[float | None, float | None]
TARGETS: dict[str, Targets] = {"hard": (60.0, 0.6), "driver_soft": (None, 2.6)}  # [ms] and [mm]


@dataclass(frozen=True)
class BrakedStop:
    """One braking."""

    speed: float  # [m/s] of the tip when told to stop
    time: float  # [s] from there until the joints rest
    distance: float  # [m] that the tip still went
    rcm_error: float  # [m] largest while braking


def measure(config: MotionConfig, simulation: SimulationConfig, stops: int) -> list[Figure]:
    """Stops of random paths in the 1 kHz simulation, told at random moments.

    Args:
        config: Settings of the controller.
        simulation: Settings of the simulated robot.
        stops: For each speed and layer of limits.
    """
    figures: list[Figure] = []
    for speed in (0.020, FAST):
        faster = with_speed(config, tip_speed=speed)
        for layer in ("hard", "driver_soft"):
            with Rig(with_layer(faster, layer), simulation) as rig:
                name = f"braking, {speed * 1e3:.0f} mm/s asked, {layer} limits"
                figures += _figures(name, TARGETS[layer], _stops(rig, stops))
    with Rig(_reckless(faster), simulation) as rig:
        name = "braking from truly 50 mm/s, which the controller refuses to go"
        figures += _figures(name, (None, None), _stops(rig, stops))
    return [*figures, _physics(config, stops)]


def _physics(config: MotionConfig, count: int) -> Figure:
    """Where the joints could stop the tip from 50 mm/s in time at all; the tool does not turn.

    At a place of a path where joint j turns by r_j per metre of the tip, the tip slows down by at
    most a = min_j (A_j / r_j), if every joint brakes as hard as its limit A_j and the jerk is
    unlimited. A stop from v takes v / a and v^2 / (2 a); so a must be at least
    max(v / 60 ms, v^2 / (2 * 0.6 mm)).
    """
    planner = Planner(load_robot(), with_layer(config, "hard"))
    q, found = np.array(config.scene.home), list[NDArray[np.float64]]()
    for pose in random_poses(config, 20 * count, seed=6, spread=0.0):
        try:
            path = planner.leg(q, pose)
        except Infeasible:
            continue
        q = path.end
        if path.length >= LEAST_LENGTH:
            found.append(_hardest(planner, path))
        if len(found) == count:
            break
    hardest, needed = np.concatenate(found), max(FAST / 0.060, FAST**2 / (2.0 * 0.0006))
    share = 100.0 * float((hardest >= needed).mean())
    note = (
        f"({needed:.2f} m/s^2 needed; the joints' limits allow {np.median(hardest):.2f} in the "
        f"median of {len(hardest)} places on {len(found)} straight paths, whatever the braking law)"
    )
    return Figure("places where 50 mm/s could stop in 60 ms and 0.6 mm", share, "%", note=note)


def _hardest(planner: Planner, path: Path) -> NDArray[np.float64]:
    """Deceleration of the tip [m/s^2] that the joints allow, at places evenly along a path."""
    samples = path.sample(planner.model.chain, planner.trocar, per_knot=1)
    rate = np.abs(samples.q[:, 1]).T  # (9, n), [rad/m] of s
    tip = np.linalg.norm(np.gradient(samples.tip, samples.s, axis=0), axis=1)  # [m/m]
    limits = planner.limits.acceleration[:, None]
    hardest: NDArray[np.float64] = tip * (limits / np.maximum(rate, 1e-9)).min(axis=0)
    return hardest


def _reckless(config: MotionConfig) -> MotionConfig:
    """The same settings, but as fast as asked, however long it then takes to stop."""
    layers = tuple(
        replace(layer, stopping_time=10.0, stopping_distance=0.1) for layer in config.limits.layers
    )
    return replace(config, limits=replace(config.limits, layers=layers))


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
    for pose in random_poses(rig.config, 20 * count, seed=6):
        view = rig.executor.snapshot
        try:
            path = rig.planner.leg(rig.planner_joints, pose)
        except Infeasible:
            continue
        if path.length < LEAST_LENGTH:
            continue
        phase = rig.along(PhaseKind.REACH, path, rig.config.controller.speed.tip_speed)
        rig.executor.post(Order(Plan(COMMANDS["tense"], "moves", (phase,)), view.serial))
        rig.tick()
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
    told, start, still = rig.robot.now, rig.tip, [rig.robot.now]

    def look() -> None:
        rcm.append(rig.rcm_error)
        if np.abs(rig.robot.reading.velocity).max() > REST:
            still[0] = rig.robot.now

    rig.executor.stop(Cause(Reason.STOP_TOPIC, "bench"))
    while rig.robot.now < told + 1.5 and (rig.is_moving or rig.robot.now < still[0] + 0.02):
        rig.tick(look)
    return BrakedStop(speed, still[0] - told, float(np.linalg.norm(rig.tip - start)), max(rcm))

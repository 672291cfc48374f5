# SPDX-License-Identifier: BSD-3-Clause
"""Item 2: how well the simulated robot keeps the trocar and its course while it moves loaded."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import islice

import numpy as np

from bench.common.rig import Rig
from rst_control.config import MotionConfig, SimulationConfig
from rst_control.kinematics.configuration import robot_joints
from rst_control.trajectory.motion_profile import MotionBounds, MotionProfile
from rst_control.trajectory.path import Path, speed_bounds
from rst_control.types import PathState, Setpoint
from support.figures import Figure

SPEEDS = (0.020, 0.050)  # [m/s]
LOAD = np.array([0.0, 0.0, -2.0])  # [N] on the tip, beside gravity
JOINT_ERROR = (0.11, 0.11, 0.11)  # [rad] pitch and jaws: OpenRST's own mean tracking error
MIN_LENGTH = 0.035  # [m] of a path, so that the speed is reached
REST = 0.05  # [s] at the end of each path


def measure(config: MotionConfig, simulation: SimulationConfig, legs: int) -> list[Figure]:
    """Errors while moving along random paths at both speeds, with true and with wrong tool joints.

    Args:
        config: Settings of planning.
        simulation: Settings of the simulated robot.
        legs: Paths for each speed.
    """
    figures: list[Figure] = []
    for speed in SPEEDS:
        for is_off, error in ((False, (0.0, 0.0, 0.0)), (True, JOINT_ERROR)):
            settings = replace(simulation.simulator, tool_joint_error=error)
            with Rig(config, replace(simulation, simulator=settings)) as rig:
                figures += _errors(rig, legs, speed, is_off)
    return figures


def _errors(rig: Rig, legs: int, speed: float, is_off: bool) -> list[Figure]:
    seen: list[tuple[float, float]] = []
    rig.robot.push_load(LOAD)
    rig.robot.advance(rig.robot.now + 0.2)
    reached = 0.0
    for path, bounds in _ways(rig, legs, speed):
        top = _follow(rig, path, bounds, lambda: seen.append((rig.rcm_error, rig.tip_error)))
        reached = max(reached, top)
    if rig.robot.fault:
        raise RuntimeError(f"the simulated robot stopped: {rig.robot.fault}")
    rcm, tip = np.array(seen).T * 1e6
    name = f"executed at {speed * 1e3:.0f} mm/s"
    if is_off:
        name += ", tool joints 0.11 rad off"
    note = f"({len(rcm)} steps of 1 ms, 2 N at the tip, reached {reached * 1e3:.0f} mm/s)"
    rms = float(np.sqrt(np.mean(rcm**2)))
    limit = 25.0 if speed == SPEEDS[0] and not is_off else None
    return [
        Figure(f"{name}: RCM error max", float(rcm.max()), "um", 10.0, note=note),
        Figure(f"{name}: RCM error rms", rms, "um", 3.0),
        Figure(f"{name}: tip error max", float(tip.max()), "um", limit),
    ]


def _ways(rig: Rig, legs: int, speed: float) -> Iterator[tuple[Path, MotionBounds]]:
    """Long random paths one after the other, with the hardest motion that the joints can follow."""
    planner, settings = rig.planner, rig.config.controller.speed
    for path in islice(rig.ways(20 * legs, seed=2, min_length=MIN_LENGTH), legs):
        samples = path.sample(planner.model.chain, planner.trocar)
        top, acceleration = speed_bounds(samples, planner.limits, speed, settings.acceleration)
        yield path, MotionBounds(top, acceleration, settings.jerk)


def _follow(rig: Rig, path: Path, bounds: MotionBounds, observe: Callable[[], None]) -> float:
    """Lead the robot along a path, observed after each step of the physics; returns top speed."""
    profile, still, top = MotionProfile(PathState(0.0), bounds), REST, 0.0
    profile.go_to(path.length)
    while still > 0.0:
        state = profile.step(rig.period)
        top = max(top, state.speed)
        point = path.evaluate(state.s)
        joints, velocity = robot_joints(point.q, 0.0), robot_joints(point.dq * state.speed, 0.0)
        rig.robot.servo_jp(Setpoint(joints, velocity, rig.robot.now))
        rig.robot.advance(rig.robot.now + rig.period, observe)
        still -= rig.period if profile.is_done else 0.0
    return top

# SPDX-License-Identifier: BSD-3-Clause
"""What the driver's other way can give: one trajectory goal for each motion, ended by in/stop.

The controller does not lead the arm like this; the figures say what it would have to live with. A
planned way is sent as one goal, its joints every 25 ms, and is stopped at half of it. A pull is a
goal over the rest of the pull path at a steady speed, stopped when the tension, looked at 40 times
a second, has its target.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from bench.kinova.rig import STEP, KinovaRig
from rst_control.kinematics.configuration import planning_joints
from rst_control.kinova.bridge import Lead
from rst_control.kinova.stand_in.goals import Goal, GoalState
from rst_control.kinova.stand_in.waypoints import Point
from rst_control.trajectory.path import Path
from rst_control.trajectory.profile import Bounds, Profile
from rst_control.types import PathState
from support.figures import Figure

NAME = "kinova_strict, one trajectory goal"
PERIOD = 0.025  # [s] between way-points, and between measurements
PULL_SPEEDS = (0.002, 0.005, 0.010)  # [m/s]
BACK = Bounds(0.003, 0.01, 10.0)  # on the way back after a pull
REST = 2e-3  # [rad/s]
LONGEST = 60.0  # [s] of one motion
AFTER = 1.0  # [s] that is looked at after the stop


@dataclass
class Handle:
    """A goal and what the driver answers."""

    goal: Goal
    state: GoalState = GoalState.ACTIVE
    answers: list[str] = field(default_factory=list)

    def reject(self) -> None:
        """Refused."""
        self.answers.append("rejected")

    def accept(self) -> None:
        """Taken up."""

    def succeed(self, code: int) -> None:
        """Ended well."""
        self.answers.append(f"succeeded {code}")

    def abort(self, code: int, words: str) -> None:
        """Ended badly."""
        self.answers.append(f"aborted {code}: {words}")

    def cancel(self) -> None:
        """Cancelled."""
        self.answers.append("cancelled")


@dataclass
class Ran:
    """One goal, run until it was stopped or had ended."""

    begins: float = np.nan  # [s] from the goal to the first motion
    stops: float = 0.0  # [s] from in/stop until the arm rests
    way: float = 0.0  # [m] that the tip goes in that time
    moving: float = 0.0  # [m] RCM error before, at most
    stopping: float = 0.0  # [m] and after


def measure(rig: KinovaRig) -> list[Figure]:
    """Figures of goals.

    Args:
        rig: It has just taken tissue by "tense". Its controller is asked for "release" only.
    """
    grasp = rig.executor.view.grasp
    if grasp is None:
        raise RuntimeError("nothing is held")
    figures = [_pulled(rig, grasp.pull, grasp.s, speed) for speed in PULL_SPEEDS]
    rig.run(0.3)
    rig.give("hey robot")
    if why_not := rig.finish("release"):
        raise RuntimeError(why_not)
    rig.run(0.3)
    path = rig.planner.reach(planning_joints(rig.robot.reading.position)[0])[-1]
    pace = rig.planner.bounds(path, rig.config.controller.speed.tip_speed)
    far = float(np.abs(path.evaluate(0.5 * path.length).q - path.start).max())

    def is_half() -> bool:
        q, _ = planning_joints(rig.robot.reading.position)
        return bool(np.abs(q - path.start).max() >= far)

    ran = _run(rig, _points(path, 0.0, path.length, pace), is_half)
    return [
        *figures,
        Figure(f"{NAME}: from goal to motion", ran.begins * 1e3, "ms"),
        Figure(f"{NAME}: on its way: RCM error max", ran.moving * 1e6, "um"),
        Figure(f"{NAME}: stop: time", ran.stops * 1e3, "ms"),
        Figure(f"{NAME}: stop: way", ran.way * 1e3, "mm"),
        Figure(f"{NAME}: stop: RCM error max", ran.stopping * 1e6, "um"),
    ]


def _pulled(rig: KinovaRig, path: Path, s: float, speed: float) -> Figure:
    """Pull one step further from s [m], then go back there."""
    target = rig.tension + rig.config.controller.tension.step_tension
    seen = [rig.now]

    def is_reached() -> bool:
        if rig.now - seen[-1] < PERIOD:
            return False
        seen.append(rig.now)
        return rig.tension >= target

    begun = rig.now
    _run(rig, _points(path, s, path.length, Bounds(speed, 0.05, 10.0)), is_reached)
    over, lasts = rig.tension - target, rig.now - begun - AFTER
    q, _ = planning_joints(rig.robot.reading.position)
    back = Path(np.array([q, path.evaluate(s).q]), np.zeros((2, 9)), 0.01)
    _run(rig, _points(back, 0.0, back.length, BACK), lambda: False)
    name = f"{NAME}: pull more at {speed * 1e3:.0f} mm/s: overshoot"
    return Figure(name, over, "N", note=f"(took {lasts:.2f} s)")


def _run(rig: KinovaRig, points: tuple[Point, ...], is_there: Callable[[], bool]) -> Ran:
    """Send a goal, and stop the arm once it is there; without a stop, wait for the goal's end."""
    _leave_alone(rig)
    handle, ran = Handle(Goal(rig.arm_names, points, 0.0)), Ran()
    rig.drivers.driver.take_goal(handle)
    sent, told, start = rig.now, np.nan, rig.tip
    while not rig.now > told + AFTER:
        rig.step()
        moves, error = rig.speed > REST, rig.rcm_error
        if moves and np.isnan(ran.begins):
            ran.begins = rig.now - sent
        if not np.isnan(told):
            ran.stopping = max(ran.stopping, error)
            ran.stops = rig.now - told if moves else ran.stops
            continue
        ran.moving = max(ran.moving, error)
        if not np.isnan(ran.begins) and is_there():
            told, start = rig.now, rig.tip
            rig.stop()
        elif handle.answers or rig.now > sent + LONGEST:
            break
    if np.isnan(told) and handle.answers != ["succeeded 0"]:
        raise RuntimeError(f"the goal ended by itself: {handle.answers or 'never'}")
    ran.way = float(np.linalg.norm(rig.tip - start))
    return ran


def _leave_alone(rig: KinovaRig) -> None:
    """Without set-points the bridge stops the arm, and then sends nothing any more."""
    for _ in range(round(AFTER / STEP)):
        rig.step()
    if rig.bridge.lead is not Lead.NOBODY:
        raise RuntimeError("the bridge goes on")


def _points(path: Path, begin: float, end: float, bounds: Bounds) -> tuple[Point, ...]:
    """Motion along a path from one s [m] to another, every 25 ms, as points of a goal."""
    profile = Profile(PathState(begin), bounds)
    profile.go_to(end)
    points, time = [], 0.0
    while not profile.is_done:
        q = path.evaluate(profile.state.s).q
        points.append(Point(tuple(q[:7].tolist()), time))
        profile.step(PERIOD)
        time += PERIOD
    return (*points, Point(tuple(path.evaluate(end).q[:7].tolist()), time))

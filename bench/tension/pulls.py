# SPDX-License-Identifier: BSD-3-Clause
"""Pulls led by an estimate from joint torques: late, noisy and wrong, on tissue of many kinds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import exp
from pathlib import Path

import numpy as np
import yaml
from numpy.typing import NDArray

from bench.common.rig import Rig, with_tissue
from rst_control.config import MotionConfig, load_motion_config, load_simulation_config
from rst_control.config.torque_tension import TorqueTensionConfig, load_torque_tension
from support.figures import ROOT, Figure

Array = NDArray[np.float64]
SETTINGS = ROOT / "launch" / "joint_torque.yaml"
STIFFNESSES = (50.0, 100.0, 200.0, 500.0, 1000.0)  # [N/m]; 200 is the stiffest that is expected
WRONG = (-2.0, -1.0, 0.0, 1.0, 2.0)  # standard deviations by which the estimate is wrong throughout
SIGMA = 0.2  # [N] of one estimate, see the figures beside these
NOISE = 0.2  # [N] of one reading, before the filter


class LateEstimate:
    """What an estimator makes of the force on the jaws; a `LightRobot.sensor`.

    Args:
        config: Rate and filter of the estimator.
        error: By which it is wrong while anything is felt [N].
        way: Unit vector of the pull, base frame. Shape (3,).
        clock: Time [s].
    """

    def __init__(
        self, config: TorqueTensionConfig, error: float, way: Array, clock: Callable[[], float]
    ) -> None:
        self._period, self._time = 1.0 / config.rate, config.filter_time
        self._error, self._way, self._clock = error, way, clock
        self._rng = np.random.default_rng(7)
        self._last, self._noise, self._filtered = -np.inf, 0.0, np.zeros(3)
        self._told = np.zeros(3)

    def __call__(self, force: Array) -> Array:
        """The estimate while the true force on the jaws is this [N]. Shape (3,)."""
        now = self._clock()
        span = now - self._last
        if span < self._period - 1e-9:
            return self._told
        new = 1.0 - exp(-span / self._time)
        self._last = now
        self._filtered = self._filtered + new * (force - self._filtered)
        self._noise += new * (self._rng.normal() * NOISE - self._noise)
        wrong = self._error * bool(np.linalg.norm(self._filtered) > 0.02)
        self._told = self._filtered - self._way * (wrong + self._noise)
        return self._told


def measure_pulls() -> list[Figure]:
    """Say "tense", then "pull more", each with an estimate that is wrong by up to two sigma."""
    config, estimator = _settings(SETTINGS), load_torque_tension()
    away, peaks, lost = [], [], 0
    for stiffness in STIFFNESSES:
        for wrong in WRONG:
            goals, reached, peak = _pull(config, estimator, stiffness, wrong * SIGMA)
            away += [r - g for g, r in zip(goals, reached, strict=True)]
            lost += 2 - len(goals)
            peaks.append(peak)
    count = len(STIFFNESSES) * len(WRONG)
    note = f"({count} pulls, tissue of 50 to 1000 N/m, estimate wrong by up to {2 * SIGMA:g} N)"
    limit = config.controller.tension.limit
    return [
        Figure("pulls led by it: highest true tension", max(peaks), "N", limit, note=note),
        Figure(
            "pulls led by it: true tension away from the asked, mean", float(np.mean(away)), "N"
        ),
        Figure(
            "pulls led by it: 95 % of tensions within", float(np.quantile(np.abs(away), 0.95)), "N"
        ),
        Figure("pulls led by it: given up, for a tension that could not be true", lost, ""),
    ]


def _settings(file: Path) -> MotionConfig:
    base = load_motion_config()
    changes = yaml.safe_load(file.read_text(encoding="utf-8"))["controller"]["tension"]
    tension = replace(base.controller.tension, **changes)
    return replace(base, controller=replace(base.controller, tension=tension))


def _pull(
    config: MotionConfig, estimator: TorqueTensionConfig, stiffness: float, error: float
) -> tuple[list[float], list[float], float]:
    """Tensions asked for and truly reached [N], and the highest on the way."""
    goals, reached, peak = [], [], [0.0]
    tension = config.controller.tension
    way = np.array(estimator.pull_direction) / np.linalg.norm(estimator.pull_direction)
    settings = with_tissue(config, stiffness=stiffness)
    with Rig(settings, load_simulation_config(), is_light=True) as rig:
        robot = rig.robot

        def true() -> float:
            return float(np.linalg.norm(robot.force))

        def estimate(force: Array) -> Array:
            peak[0] = max(peak[0], true())
            return late(force)

        late = LateEstimate(estimator, error, way, lambda: robot.now)
        robot.sensor = estimate  # type: ignore[union-attr]
        rig.wake()
        goal = tension.initial
        for words in ("tense", "pull more"):
            if rig.finish(words):
                break
            goals.append(goal)
            reached.append(true())
            goal += tension.step_tension
    return goals, reached, peak[0]

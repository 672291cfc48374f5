# SPDX-License-Identifier: BSD-3-Clause
"""Pulls by joint torques through the bridge, on the strict simulation of the drivers.

Its arm reports torques with the noise, offsets and friction of kinova_stand_in.yaml, 40 times a
second. The tension that the controller is told is the estimate's; the true one is only looked at.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import yaml

from bench.kinova.rig import KinovaRig, kinova_motion
from rst_control.config import URDF_FILE
from rst_control.config.torque_tension import load_torque_tension
from rst_control.tension.torque_estimator import TensionEstimate, TorqueTension
from rst_control.types import Measurement
from support.figures import ROOT, Figure

SETTLING = 1.0  # [s] after a command, before the estimate is compared
COMMANDS = {"tense": 0.0, "pull more": 1.0, "pull less": -1.0}  # steps of the tension asked for


class TorqueRig(KinovaRig):
    """The rig whose controller is told the estimate in the place of the sensor's force."""

    def __init__(self) -> None:
        changes = yaml.safe_load((ROOT / "launch" / "joint_torque.yaml").read_text("utf-8"))
        motion = kinova_motion()
        tension = replace(motion.controller.tension, **changes["controller"]["tension"])
        super().__init__(replace(motion, controller=replace(motion.controller, tension=tension)))
        text = URDF_FILE.read_text(encoding="utf-8")
        self._estimator = TorqueTension(load_torque_tension(), text)
        self.found: TensionEstimate | None = None  # the newest estimate
        self._told: Measurement | None = None
        self.peak = 0.0  # [N] highest true tension
        tick = self.executor.tick
        self.executor.tick = lambda now, measured: tick(now, self._telling(measured))  # type: ignore[method-assign]

    def _telling(self, measured: Measurement | None) -> Measurement | None:
        self.peak = max(self.peak, self.tension)
        if measured is None:
            return None
        if self._told is None or measured.stamp > self._told.stamp:
            self.found = self._estimator.update(measured, self.planner.trocar)
            self._told = measured
        assert self.found is not None
        force, invalid = self.found.force, self.found.tension_invalid_reason
        return replace(measured, force=force, tension_invalid_reason=invalid)


def measure_strict() -> list[Figure]:
    """One session: each pull, then release."""
    figures: list[Figure] = []
    rig = TorqueRig()
    with rig:
        rig.run(0.2)
        rig.home()
        rig.give("hey robot")
        tension = rig.config.controller.tension
        goal, errors = tension.initial, []
        for words, step in COMMANDS.items():
            goal += step * tension.step_tension
            if why := rig.finish(words):
                return [*figures, Figure(f"strict drivers: {words!r}", 1.0, "", 0.0, note=why)]
            rig.run(SETTLING)
            errors.append(_told(rig) - rig.tension)
            name = f"strict drivers: true tension after {words!r}"
            figures.append(Figure(name, rig.tension, "N", note=f"({goal:.2f} N asked for)"))
        rig.finish("release")
    return [*figures, *_summary(rig, errors)]


def _told(rig: TorqueRig) -> float:
    return rig.found.tension if rig.found is not None else float("nan")


def _summary(rig: TorqueRig, errors: Sequence[float]) -> list[Figure]:
    worst = float(np.abs(errors).max())
    limit = rig.config.controller.tension.limit
    return [
        Figure("strict drivers: estimate away from the true tension, at rest, max", worst, "N"),
        Figure("strict drivers: highest true tension", rig.peak, "N", limit),
    ]

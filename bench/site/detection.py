# SPDX-License-Identifier: BSD-3-Clause
"""How soon the bridge sees what goes wrong in motion, by the rate of the arm's feedback.

On the way between random poses, at up to 20 mm/s, the feedback is lost, a joint is held, or the arm
goes into fault. The time runs from there to the bridge's latch. All in lock-step: what ROS itself
takes is not in it.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from contextlib import suppress
from dataclasses import replace
from typing import Final

import numpy as np

from bench.common.resumable import measured
from bench.kinova.rig import STEP, KinovaRig, kinova_motion
from bench.site.stops import DoesNotSetOff, Drill
from rst_control.kinova.arm_state import ArmReport, ArmState, Banks
from rst_control.kinova.config import KinovaConfig, load_kinova_config
from support.figures import Figure

FULL: Final = 15  # trials of each kind and rate
TRIALS: Final = int(os.environ.get("BENCH_DETECTIONS", str(FULL)))
RATES: Final = (40.0, 200.0, 1000.0)  # [Hz]
PERIODS: Final = 1.4  # of the feedback, and
HOLD_UP: Final = 0.025  # [s] by host or network, after which feedback counts as lost
ROUND: Final = 0.005  # [s] of the bridge's loop
PATIENCE: Final = 2.0  # [s] for a latch
KINDS: Final = ("feedback lost", "joint held", "fault of the arm")
PROCESSES: Final = 2
TORQUE: Final = ArmReport(ArmState.IN_FAULT, 1, 0.0, joints=(Banks(0x20),))


def measure() -> list[Figure]:
    """Each kind at each rate."""
    pairs = [(name, rate) for name in KINDS for rate in RATES]
    with ProcessPoolExecutor(PROCESSES) as pool:
        found = list(pool.map(_times, *zip(*pairs, strict=True)))
    figures = [measured(TRIALS, "trials of each kind and rate", FULL)]
    for (name, rate), times in zip(pairs, found, strict=True):
        title, ms = f"{name}, feedback at {rate:.0f} Hz", 1e3 * np.array(times)
        note = f"({len(times)} trials)"
        figures.append(Figure(f"{title}: latched after, p50", float(np.median(ms)), "ms"))
        most = Figure(f"{title}: latched after, max", float(ms.max()), "ms", _bound(name, rate))
        figures.append(replace(most, note=note))
    return figures


def _bound(name: str, rate: float) -> float | None:
    """What the settings promise [ms]; None: a held joint shows once it is far enough off."""
    if name == "joint held":
        return None
    seen = settings(rate).bridge.arm.feedback_age if name == "feedback lost" else 1.0 / rate
    return (seen + ROUND) * 1e3


def settings(rate: float) -> KinovaConfig:
    """Those of the bridge for feedback at a rate [Hz]."""
    config = load_kinova_config()
    arm = replace(config.bridge.arm, feedback_age=PERIODS / rate + HOLD_UP)
    return replace(config, bridge=replace(config.bridge, arm=arm))


def _times(name: str, rate: float) -> list[float]:
    found: list[float] = []
    rng = np.random.default_rng([int(rate), *name.encode()])
    while len(found) < TRIALS:
        with KinovaRig(kinova_motion(), settings(rate), feedback_rate=rate) as rig:
            rig.run(0.8)
            rig.home()
            drill = Detection(rig, rng)
            with suppress(DoesNotSetOff):
                while len(found) < TRIALS:
                    found.append(drill.time(name))
    return found


class Detection(Drill):
    """Lets something go wrong on the way, and waits for the latch."""

    def time(self, name: str) -> float:
        """From what goes wrong to the latch [s]."""
        rig, course = self._rig, self._course()
        self._set_off(course)
        for _ in range(int(self._rng.integers(round(1.0 / (40.0 * STEP))))):
            rig.step()  # anywhere between two states
        begun, each = rig.now, self._wrong(name)
        while not rig.bridge.fault(rig.now):
            if rig.now - begun > PATIENCE:
                raise RuntimeError(f"{name}: nothing was latched within {PATIENCE} s")
            if round((rig.now - begun) / STEP) % round(rig.period / STEP) == 0:
                rig.bridge.servo_jp(course(rig.now), rig.now)
            rig.step()
            each()
        found = rig.now - begun
        rig.lost = None
        rig.drivers.driver.arm.interfere(ArmReport(ArmState.SERVOING_READY, 1, 0.0), rig.now)
        self._repair()
        return found

    def _wrong(self, name: str) -> Callable[[], None]:
        arm = self._rig.drivers.driver.arm
        if name == "feedback lost":
            return self.lose("feedback")
        if name == "fault of the arm":
            arm.interfere(TORQUE, self._rig.now)
            return lambda: None
        joint = int(np.abs(arm.velocity).argmax())
        place = float(arm.position[joint])

        def hold() -> None:
            arm.position[joint], arm.velocity[joint] = place, 0.0

        return hold

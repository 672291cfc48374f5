# SPDX-License-Identifier: BSD-3-Clause
"""Item 4: time of one control tick, state in and set-point out."""

from __future__ import annotations

import gc
import itertools
import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from bench.common.rig import Rig
from rst_control.config import MotionConfig, SimulationConfig
from rst_control.planning.plan import PhaseKind
from rst_control.types import Measurement
from support.figures import Figure

Array = NDArray[np.float64]
WARM_UP = 200  # ticks that are not counted


def measure(config: MotionConfig, simulation: SimulationConfig, ticks: int) -> list[Figure]:
    """Times of the executor's ticks while moving and while pulling.

    Args:
        config: Settings of the controller.
        simulation: Settings of the simulated robot.
        ticks: To measure, of each.
    """
    with Rig(config, simulation, is_light=True) as rig:
        rig.wake()
        seeds = itertools.count(40)
        reach = _ticks(rig, lambda: rig.set_off(next(rig.ways(50, next(seeds)))), ticks)
    with Rig(config, simulation, is_light=True) as rig:
        rig.wake()
        pull = _ticks(rig, lambda: _pull_on(rig), ticks // 2)
    ours = np.concatenate([reach, pull])
    p50, p99 = np.percentile(ours, (50, 99))
    note = f"({len(ours)} ticks in motion: along paths and pulling tissue)"
    return [
        Figure("control tick median", p50 * 1e6, "us", 60.0, note=note),
        Figure("control tick p99", p99 * 1e6, "us", 200.0),
        Figure("control tick max", ours.max() * 1e6, "us"),
    ]


def _ticks(rig: Rig, renew: Callable[[], None], count: int) -> Array:
    """Time ticks of the executor while something moves; `renew` sets it moving again."""
    times = np.empty(count + WARM_UP)
    gc.collect()
    gc.disable()
    try:
        for n in range(len(times)):
            if not rig.is_moving:
                gc.collect()
                renew()
            measured: Measurement = rig.robot.measured_js()
            begin = time.perf_counter()
            setpoint = rig.executor.tick(rig.robot.now, measured)
            times[n] = time.perf_counter() - begin
            if setpoint is not None:
                rig.robot.servo_jp(setpoint)
            rig.robot.advance(rig.robot.now + rig.period)
    finally:
        gc.enable()
    return times[WARM_UP:]


def _pull_on(rig: Rig) -> None:
    """Grasp and pull; then more and less in turn."""
    if not rig.executor.snapshot.is_tissue_held:
        rig.give("tense")
        rig.until(lambda: rig.executor.snapshot.phase == PhaseKind.PULL.value)
        return
    rig.give("pull more" if rig.executor.snapshot.tension < 1.0 else "pull less", tension=0.5)

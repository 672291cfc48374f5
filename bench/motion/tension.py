# SPDX-License-Identifier: BSD-3-Clause
"""Item 7: tension in newtons over a 50-fold range of tissue stiffness.

The way of the tip takes time by itself: displacement over the pull speed. Times are given in total,
and beyond that unavoidable travel. A first pull counts from the moment when the tissue is loaded.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bench.common.rig import Rig, with_tissue
from bench.motion import tissue_laws
from rst_control.config import MotionConfig, SimulationConfig
from rst_control.planning.plan import PhaseKind
from support.figures import Figure, share

Array = NDArray[np.float64]

# 50-fold. Softer than 67 N/m needs more than the 30 mm of the pull path for 2 N and is refused or
# ends at the displacement limit.
STIFFNESSES = (80.0, 200.0, 600.0, 1500.0, 4000.0)  # [N/m]
TARGETS = (0.3, 1.0, 2.0)  # [N] of first pulls; each is followed by one step up or down by
STEPS = (1.7, 1.0, -1.7)  # [N]
RANGE = (0.3, 2.0)  # [N] that random steps stay in
STEP_SIZES = (0.05, 1.7)  # [N] of them
SMALL = 0.25  # [N] the usual step
HOLD = 0.5  # [s] that a tension is watched after it was reached
TOLERANCE = 0.02  # [N]
LIMIT = 2.4  # [N]
LOADED = 0.05  # [N] from which tissue counts as loaded
NODES = (9, 9)  # of the sheets for the random steps; the others have those of the scene
NOISE = 0.005  # [N] rms of the noisy sensor, which is one sample late, too
NOISY_SHARE = 0.3  # of the random steps, once more with that sensor


@dataclass(frozen=True)
class TensionChange:
    """One change of tension."""

    start: float  # [N]
    target: float  # [N]
    held: float  # [N] at the end
    error: float  # [N] largest while held
    overshoot: float  # share of the target, beyond it in the way of the change
    settle: float  # [s] until it stays within tolerance, from when the tissue was loaded
    total: float  # [s] the same from the start of the pull
    travel: float  # [s] that the way since the tissue was loaded takes at full speed
    peak: float  # [N]


class LateSensor:
    """Reports a force with noise, one sample late.

    Args:
        seed: Of the noise.
    """

    def __init__(self, seed: int) -> None:
        self._rng = np.random.default_rng(seed)
        self._waiting: deque[Array] = deque([np.zeros(3)])

    def __call__(self, force: Array) -> Array:
        """What is reported of a force (3,), base frame, [N], now."""
        self._waiting.append(force)
        late = self._waiting.popleft()
        size = float(np.linalg.norm(late))
        way = late / size if size > 0.0 else np.array([0.0, 0.0, -1.0])
        return late + self._rng.normal(0.0, NOISE) * way


def measure(config: MotionConfig, simulation: SimulationConfig, steps: int) -> list[Figure]:
    """First pulls and large steps in PyBullet; many random steps on the same tissue model; laws.

    Args:
        config: Settings of the controller.
        simulation: Settings of the simulated robot.
        steps: Number of random "pull more" and "pull less".
    """
    firsts: list[TensionChange] = []
    singles: list[TensionChange] = []
    for stiffness in STIFFNESSES:
        for target, step in zip(TARGETS, STEPS, strict=True):
            with Rig(with_tissue(config, stiffness=stiffness), simulation) as rig:
                rig.wake()
                firsts.append(_pull(rig, "tense", target, 0.0))
                words = "pull more" if step > 0.0 else "pull less"
                singles.append(_step(rig, words, abs(step), target))
    randoms = list(_randoms(config, simulation, steps))
    noisy = list(_randoms(config, simulation, round(NOISY_SHARE * steps), is_noisy=True))
    return [
        *_figures("tension", firsts, singles + randoms),
        *_figures("tension, noisy late sensor", [], noisy),
        *_directions(randoms + noisy),
        *tissue_laws.measure(config.controller, 2 * steps),
    ]


def _figures(name: str, firsts: list[TensionChange], steps: list[TensionChange]) -> list[Figure]:
    everything = firsts + steps
    small = [p.total for p in steps if abs(p.target - p.start) <= SMALL + TOLERANCE]
    totals = [p.total for p in steps]
    travel = max(p.travel for p in steps)
    return [
        Figure(
            f"{name}: held error max",
            max(p.error for p in everything),
            "N",
            TOLERANCE,
            note=f"({len(everything)} pulls, 0.3 to 2.0 N, 80 to 4000 N/m)",
        ),
        Figure(f"{name}: overshoot max", 100.0 * max(p.overshoot for p in everything), "%", 5.0),
        Figure(f"{name}: peak", max(p.peak for p in everything), "N", LIMIT),
        Figure(
            f"{name}: step settled beyond the travel, max",
            max(p.total - p.travel for p in steps),
            "s",
            0.5,
            note=f"({len(steps)} steps of {STEP_SIZES[0]} to {STEP_SIZES[1]} N)",
        ),
        Figure(
            f"{name}: step settled in all, max",
            max(totals),
            "s",
            note=f"(the travel alone takes up to {travel:.2f} s on soft tissue)",
        ),
        Figure(f"{name}: step settled in all, p95", float(np.percentile(totals, 95)), "s"),
        Figure(
            f"{name}: step of up to {SMALL} N settled in all, max",
            max(small, default=0.0),
            "s",
            0.5,
            note=f"({len(small)} steps)",
        ),
        *_first_figures(name, firsts),
    ]


def _first_figures(name: str, firsts: list[TensionChange]) -> list[Figure]:
    if not firsts:
        return []
    return [
        Figure(
            f"{name}: first pull settled beyond the travel, max",
            max(p.settle - p.travel for p in firsts),
            "s",
            0.5,
            note=f"(from {LOADED} N on)",
        ),
        Figure(
            f"{name}: first pull settled in all, max",
            max(p.total for p in firsts),
            "s",
            note="(from zero)",
        ),
    ]


def _directions(pulls: list[TensionChange]) -> list[Figure]:
    right = sum((p.held > p.start) == (p.target > p.start) for p in pulls)
    return [share('tension: "pull more" more, "pull less" less', right, len(pulls), 100.0)]


def _randoms(
    config: MotionConfig, simulation: SimulationConfig, steps: int, is_noisy: bool = False
) -> Iterator[TensionChange]:
    for stiffness in STIFFNESSES:
        rng = np.random.default_rng([int(stiffness), is_noisy])
        settings = with_tissue(config, stiffness=stiffness, nodes=NODES)
        with Rig(settings, simulation, is_light=True) as rig:
            if is_noisy:
                rig.robot.sensor = LateSensor(int(stiffness))  # type: ignore[union-attr]
            rig.wake()
            _pull(rig, "tense", 1.0, 0.0)
            for _ in range(max(1, steps // len(STIFFNESSES))):
                now = rig.executor.snapshot.tension_target
                words, step = _random_step(rng, now)
                yield _step(rig, words, step, now)


def _random_step(rng: np.random.Generator, now: float) -> tuple[str, float]:
    """Words and size [N] of a step that stays in the range."""
    while True:
        step, words = float(rng.uniform(*STEP_SIZES)), str(rng.choice(["pull more", "pull less"]))
        if RANGE[0] <= (now + step if words == "pull more" else now - step) <= RANGE[1]:
            return words, step


def _step(rig: Rig, words: str, step: float, now: float) -> TensionChange:
    return _pull(rig, words, now + step if words == "pull more" else now - step, step)


def _pull(rig: Rig, words: str, target: float, step: float) -> TensionChange:
    """Change the tension and watch it; `step` [N] is 0 for "tense"."""
    seen: list[tuple[float, float, float]] = []
    start = float(np.linalg.norm(rig.robot.force))
    began = rig.robot.now
    pending = rig.give(words, tension=step or target)
    if not pending.reply.result(0).accepted:
        raise RuntimeError(f'"{words}" refused: {pending.reply.result(0).message}')
    if not step:
        rig.until(lambda: rig.executor.snapshot.phase == PhaseKind.PULL.value)
        began = rig.robot.now

    def observe() -> None:
        force = float(np.linalg.norm(rig.robot.force))
        seen.append((rig.robot.now - began, force, rig.executor.snapshot.path_position))

    while not pending.ended.done():
        rig.tick(observe)
    if (outcome := pending.ended.result(0)).kind != "succeeded":
        raise RuntimeError(f'"{words}" {outcome.kind}: {outcome.message}')
    done = len(seen)
    for _ in range(round(HOLD / rig.period)):
        rig.tick(observe)
    speed = rig.config.controller.speed.pull_speed
    return _judge(np.array(seen), done, start, target, speed)


def _judge(seen: Array, done: int, start: float, target: float, speed: float) -> TensionChange:
    time, force, s = seen.T
    outside = np.flatnonzero(np.abs(force - target) > TOLERANCE)
    last = int(outside[-1]) if len(outside) else 0
    loaded = 0 if start > LOADED else int(np.argmax(force > LOADED))
    sign = 1.0 if target > start else -1.0
    beyond = max(0.0, float((sign * (force - target)).max()))
    return TensionChange(
        start=start,
        target=target,
        held=float(force[-1]),
        error=float(np.abs(force[done:] - target).max()),
        overshoot=beyond / target,
        settle=float(time[last] - (time[loaded] if loaded else 0.0)),
        total=float(time[last]),
        travel=abs(float(s[last] - s[loaded])) / speed,
        peak=float(force.max()),
    )

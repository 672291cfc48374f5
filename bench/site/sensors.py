# SPDX-License-Identifier: BSD-3-Clause
"""Force sensors that fail: what each reports of the true force, drawn at random."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Fault = Callable[[float, Array], Array]  # (time since its onset [s], true force [N]) -> reported

NOISE: Final = (0.0, 0.020)  # [N] standard deviation of each axis
HEALTHY_NOISE: Final = 0.005  # [N]
TOP: Final = 2.4  # [N] that a stuck sensor may read
ONSETS: Final = ("before", "at", "after")  # the grasp
DELAY: Final = 0.3  # [s] at most
LOWEST, HIGHEST = 0.3, 3.0  # scales


@dataclass(frozen=True)
class Failure:
    """What goes wrong, as drawn."""

    make: Callable[[], Fault]  # anew for each situation, for it may remember
    is_scaled: bool = False  # for a while at least it reads the force by a factor


@dataclass(frozen=True)
class SensorFault:
    """One way to fail, as drawn."""

    kind: str
    failure: Failure
    onset: str  # one of ONSETS
    after: float  # [s] in which tissue was held when it begins, where it begins after the grasp
    noise: float  # [N]
    seed: int


def healthy(rng: np.random.Generator) -> SensorFault:
    """A sensor that works, as noisy as the settings say."""
    noise = float(rng.uniform(0.0, HEALTHY_NOISE))
    return SensorFault("none", Failure(lambda: lambda _, force: force), "before", 0.0, noise, 1)


def draw(rng: np.random.Generator, kind: str) -> SensorFault:
    """A fault of one kind."""
    return SensorFault(
        kind=kind,
        failure=KINDS[kind](rng),
        onset=str(rng.choice(ONSETS)),
        after=float(rng.uniform(0.0, 6.0)),
        noise=float(rng.choice([0.0, rng.uniform(*NOISE)])),
        seed=int(rng.integers(2**31)),
    )


class Sensor:
    """Reports forces, the true ones until its fault begins."""

    def __init__(self, fault: SensorFault) -> None:
        self._fault, self._noise = fault, np.random.default_rng(fault.seed)
        self._apply = fault.failure.make()
        self._began: float | None = None
        self._grasped: float | None = None

    def __call__(self, now: float, force: Array, is_held: bool) -> Array:
        """The force that is reported at a time [s]."""
        if is_held and self._grasped is None:
            self._grasped = now
        if self._began is None and self._begins(now):
            self._began = now
        if self._began is not None:
            force = self._apply(now - self._began, force)
        if self._fault.noise:
            return force + self._noise.normal(0.0, self._fault.noise, 3)
        return force

    def _begins(self, now: float) -> bool:
        if self._fault.onset == "before":
            return True
        after = self._fault.after if self._fault.onset == "after" else 0.0
        return self._grasped is not None and now >= self._grasped + after


def _direction(rng: np.random.Generator) -> Array:
    way = rng.normal(size=3)
    unit: Array = way / np.linalg.norm(way)
    return unit


def _frozen(first: Array | None = None) -> Fault:
    """Whatever it reads first, or the force given."""
    kept: list[Array] = [] if first is None else [first]

    def fault(since: float, force: Array) -> Array:
        if not kept:
            kept.append(force)
        return kept[0]

    return fault


def stuck(rng: np.random.Generator) -> Failure:
    """At what it reads when the fault begins, or at a value of its own."""
    value = _direction(rng) * rng.uniform(0.0, TOP) if rng.random() < 0.3 else None
    return Failure(lambda: _frozen(value))


def drifting(rng: np.random.Generator) -> Failure:
    """By up to 0.3 N/s along any way, to no end."""
    rate = _direction(rng) * np.exp(rng.uniform(np.log(0.003), np.log(0.3)))
    return Failure(lambda: lambda since, force: force + rate * since)


def scaled(rng: np.random.Generator) -> Failure:
    """By LOWEST to HIGHEST, some for a while only."""
    scale = float(np.exp(rng.uniform(np.log(LOWEST), np.log(HIGHEST))))
    until = float(rng.uniform(0.1, 5.0)) if rng.random() < 0.3 else np.inf
    return Failure(
        lambda: lambda since, force: scale * force if since < until else force, is_scaled=True
    )


def delayed(rng: np.random.Generator) -> Failure:
    """By up to 0.3 s."""
    delay = float(rng.uniform(0.0, DELAY))

    def make() -> Fault:
        past: deque[tuple[float, Array]] = deque()

        def fault(since: float, force: Array) -> Array:
            past.append((since, force))
            while len(past) > 1 and past[1][0] <= since - delay:
                past.popleft()
            return past[0][1]

        return fault

    return Failure(make)


def offset(rng: np.random.Generator) -> Failure:
    """By up to 2 N along any way."""
    value = _direction(rng) * rng.uniform(0.02, 2.0)
    return Failure(lambda: lambda since, force: force + value)


def alternating(rng: np.random.Generator) -> Failure:
    """Between the truth and another fault, every 2 ms to 1 s."""
    period = float(np.exp(rng.uniform(np.log(0.002), np.log(1.0))))
    other = KINDS[str(rng.choice(["stuck", "scaled", "offset", "dead"]))](rng)

    def make() -> Fault:
        fault = other.make()
        return lambda since, force: force if int(since / period) % 2 else fault(since, force)

    return Failure(make, other.is_scaled)


def dead(rng: np.random.Generator) -> Failure:
    """Nothing."""
    return Failure(lambda: _frozen(np.zeros(3)))


def recovering(rng: np.random.Generator) -> Failure:
    """Well again after up to 5 s of another fault."""
    until = float(rng.uniform(0.1, 5.0))
    other = KINDS[str(rng.choice(["stuck", "drifting", "offset", "dead"]))](rng)

    def make() -> Fault:
        fault = other.make()
        return lambda since, force: fault(since, force) if since < until else force

    return Failure(make)


KINDS: Final[dict[str, Callable[[np.random.Generator], Failure]]] = {
    "stuck": stuck,
    "drifting": drifting,
    "scaled": scaled,
    "delayed": delayed,
    "offset": offset,
    "alternating": alternating,
    "dead": dead,
    "recovering": recovering,
}

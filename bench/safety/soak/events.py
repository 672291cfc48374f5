# SPDX-License-Identifier: BSD-3-Clause
"""What happens in a soak, drawn at random: what is said, given by hand, and what breaks."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal, get_args

import numpy as np

from rst_control.commands.table import COMMANDS

Kind = Literal["say", "talk", "hand", "stop", "fault"]
Fault = Literal[
    "joint states stop",
    "joints jump",
    "tension is no number",
    "tension jumps",
    "recorder lost",
    "heartbeat lost",
    "voice node restarts",
    "servo fault",
    "stray set-point",
    "ticks come late",
    "error in the loop",
]
FAULTS: tuple[Fault, ...] = get_args(Fault)
SPOKEN = tuple(c.phrase for c in COMMANDS.values() if not c.is_by_hand_only)
GIVEN = tuple(c.phrase for c in COMMANDS.values())
GAP = 1.2  # [s] mean time between two events
SENSIBLE = 0.6  # of the commands are the one that a person would give now
WAYS = ("{}", "{}.", "{}!", " {} ", "{},")  # in which a recogniser may write a command
SHARES: dict[Kind, float] = {"say": 0.42, "talk": 0.2, "hand": 0.14, "stop": 0.06, "fault": 0.18}
NOWHERE = ("tens", "pull", "more", "robot", "pull more and more", "halt", "go", "", "stopp the")
TALK = (
    "they will pull more people from the ward and release the beds before the morning",
    "I told him the lights were far too dim to see the stopper on the table",
    "the patient was tense all day and nobody could tell her what was wrong",
    "we should stop by the office later and ask for the results",
    "do not pull more until I have seen the vessel",
    "don't release it yet",
    "never say tense when the jaws are open",
    "he said release and she said pull less",
    "could you terminate the call with the pharmacy please",
    "is the robot ready or do we wait",
    "hey could you hand me the clip",
    "a bit more light over here",
    "what is the pressure now",
    "let us not stop here",
    "the tension looks good to me",
    "pull the curtain and release the brake of the bed",
)


@dataclass(frozen=True)
class SoakEvent:
    """One thing that happens."""

    kind: Kind
    words: str  # said or given, or which fault
    tension: float = 0.0  # [N] of a command by hand
    distance: float = 0.0  # [m] of a command by hand
    duration: float = 0.0  # [s] of a fault
    size: np.ndarray = field(default_factory=lambda: np.zeros(0))  # of a jump


@dataclass(frozen=True)
class SoakStanding:
    """What a sensible person knows of the robot."""

    is_active: bool  # voice and controller are
    is_latched: bool
    is_held: bool  # tissue is in the jaws
    is_outside: bool  # the tool is not in the patient


class Chance:
    """Draws events; the same seed draws the same.

    Args:
        rng: Source of chance.
    """

    def __init__(self, rng: np.random.Generator) -> None:
        self._rng = rng

    def gap(self) -> float:
        """Time to the next event [s]."""
        return float(self._rng.exponential(GAP))

    def late(self) -> int:
        """Ticks that a verification waits for its turn."""
        return int(self._rng.integers(0, 4))

    def event(self, standing: SoakStanding) -> SoakEvent:
        """The next event."""
        kinds = list(SHARES)
        kind = kinds[int(self._rng.choice(len(kinds), p=list(SHARES.values())))]
        if kind == "say":
            way = WAYS[int(self._rng.integers(len(WAYS)))]
            words = self._command(standing, SPOKEN)
            words = words.capitalize() if self._rng.uniform() < 0.5 else words
            return SoakEvent("say", way.format(words))
        if kind == "talk":
            return SoakEvent("talk", str(self._rng.choice(TALK)))
        if kind == "hand":
            return self._by_hand(standing)
        return SoakEvent("stop", "stop") if kind == "stop" else self._fault()

    def _command(self, standing: SoakStanding, among: tuple[str, ...]) -> str:
        if self._rng.uniform() >= SENSIBLE:
            return str(self._rng.choice(among))
        if standing.is_latched or not standing.is_active:
            return "hey robot"
        if standing.is_outside:
            return "insert" if "insert" in among else "hey robot"
        if not standing.is_held:
            return "tense"
        return str(self._rng.choice(("pull more", "pull less", "pull more", "release")))

    def _by_hand(self, standing: SoakStanding) -> SoakEvent:
        if self._rng.uniform() < 0.1:
            return SoakEvent("hand", str(self._rng.choice(NOWHERE)))
        words = self._command(standing, GIVEN)
        tension = distance = 0.0
        if (what := self._rng.uniform()) < 0.25:
            tension = float(self._rng.choice((0.1, 0.3, 0.5, 1.5, 2.0, 2.3, 50.0, -1.0, np.nan)))
        elif what < 0.45:
            distance = float(self._rng.choice((0.0005, 0.002, 0.01, 0.03, 1.0, -0.1, np.inf)))
        return SoakEvent("hand", words, tension, distance)

    def _fault(self) -> SoakEvent:
        fault: Fault = FAULTS[int(self._rng.integers(len(FAULTS)))]
        rng, size = self._rng, np.zeros(0)
        duration = float(10.0 ** rng.uniform(-2.5, 0.0))
        if fault == "joints jump":
            size = rng.normal(size=10) * 10.0 ** rng.uniform(-3.5, -0.5)
            duration = min(duration, 0.1)
        elif fault == "tension jumps":
            size = rng.normal(size=3) * 10.0 ** rng.uniform(-1.5, 0.7)
            duration = min(duration, 0.02)
        elif fault == "tension is no number":
            size = np.full(3, rng.choice((np.nan, np.inf)))
        elif fault == "stray set-point":
            size = rng.normal(size=10) * 10.0 ** rng.uniform(-2.5, -0.5)
        elif fault in ("recorder lost", "heartbeat lost"):
            duration = float(rng.uniform(0.1, 8.0))
        return SoakEvent("fault", fault, duration=duration, size=size)

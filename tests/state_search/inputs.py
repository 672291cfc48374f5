# SPDX-License-Identifier: BSD-3-Clause
"""What may happen to the controller between two ticks: every command, fault and stop there is.

All is made from the enums of the product; what a path is, and how long a phase takes, is left out.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from itertools import product

import numpy as np

from rst_control.commands.camera_step import CAMERA_STEPS
from rst_control.commands.request import Plan
from rst_control.commands.spec import CommandSpec
from rst_control.commands.table import COMMANDS
from rst_control.planning.plan import Grasp, Phase, PhaseKind
from rst_control.supervision.node_liveness import MASTER
from rst_control.types import JOINT_COUNT, Measurement

ZERO = np.zeros(JOINT_COUNT)
WAY, PULL = object(), object()  # stand for paths
AT_ONCE = (COMMANDS["hey robot"], COMMANDS["terminate"])
# Of the camera steps one stands for all: they differ in their paths alone, which are left out here.
TRIED = tuple(c for c in COMMANDS.values() if c not in CAMERA_STEPS[1:])
MOTIONS = tuple(c for c in TRIED if c not in (*AT_ONCE, COMMANDS["stop"]))
PHASES = {
    COMMANDS["tense"]: (PhaseKind.REACH, PhaseKind.PULL),
    COMMANDS["pull more"]: (PhaseKind.STEP,),
    COMMANDS["pull less"]: (PhaseKind.STEP,),
    COMMANDS["release"]: (PhaseKind.EASE,),
    COMMANDS["insert"]: (PhaseKind.INSERT,),
    COMMANDS["withdraw"]: (PhaseKind.WITHDRAW,),
    CAMERA_STEPS[0]: (PhaseKind.CAMERA_STEP,),
}
LATE = {"silent": 1.0, "long": 1.0, "overtime": 200.0}  # [s] that pass before such a tick


@dataclass(frozen=True)
class Given:
    """A verified command that is handed over."""

    command: CommandSpec
    is_spoken: bool = False
    is_fresh: bool = True  # verified in the view of this moment


@dataclass(frozen=True, eq=False)
class Input:
    """All that happens between two ticks, and how the robot is found at the second.

    Made by `one`, so that the same input is the same object.
    """

    orders: tuple[Given, ...] = ()
    is_stopped: bool = False
    found: str = "well"
    is_changed: bool = False  # the trocar was set

    def __str__(self) -> str:
        words = [f"{o.command.phrase}{'' if o.is_fresh else ' (stale)'}" for o in self.orders]
        words += ["stop"] * self.is_stopped + ["trocar set"] * self.is_changed
        return ", ".join(words) + f" [{self.found}]"


def one(orders=(), is_stopped=False, found="well", is_changed=False):
    """The input with these parts; the same object for the same parts."""
    return _made(orders, is_stopped, found, is_changed)


_made = cache(Input)


def _measurement(name):
    found = Measurement(ZERO, ZERO, ZERO, stamp=1e9, gripped=name != "slipped")
    match name:
        case "nobody":
            return None
        case "gone":
            return replace(found, connected=False)
        case "stale" | "stale, arrived":
            return replace(found, stamp=-1e9)
        case "robot fault" | "robot fault, arrived":
            return replace(found, fault="x")
        case "off course":
            return replace(found, position=ZERO + 0.5)
        case "off trocar":
            return replace(found, position=ZERO + 0.02)
        case "restless":
            return replace(found, velocity=ZERO + 1.0)
        case "too tense":
            return replace(found, force=np.full(3, 9.0))
    return found


FOUND = {
    name: _measurement(name)
    for name in (
        *("well", "arrived", "failing", "nobody", "gone", "stale", "stale, arrived"),
        *("robot fault", "robot fault, arrived", "sensor fault", "off course", "off trocar"),
        *("restless", "too tense", "slipped", *LATE, "crash"),
        *("no master", "no owner"),
    )
}
OWNER = "/surgeon"  # who gave every order
LOST = {"no master": MASTER, "no owner": OWNER}
# What brakes any motion.
WATCHED = (
    *("gone", "nobody", "stale", "robot fault", "sensor fault"),
    *("off course", "off trocar"),
    *LOST,
)


@cache
def plan_of(command):
    """What stands for the verified plan of a command."""
    pulls = (PhaseKind.PULL, PhaseKind.STEP)
    phases = tuple(Phase(k, PULL if k in pulls else WAY) for k in PHASES.get(command, ()))
    is_pull = bool(phases) and phases[-1].kind in pulls
    return Plan(command, command.phrase, phases, Grasp(PULL, WAY) if is_pull else None)


def singles():
    """Every command, every way in which it can be handed over."""
    found = [Given(c) for c in AT_ONCE]
    found += [Given(c, is_fresh=fresh) for c, fresh in product(MOTIONS, (True, False))]
    spoken = [c for c in MOTIONS if not c.is_by_hand_only]
    found += [Given(c, True, fresh) for c, fresh in product(spoken, (True, False))]
    return found


def inputs():
    """Every one of the events, alone and with those that may fall into the same tick."""
    singly, hand = singles(), [Given(c) for c in (*AT_ONCE, *MOTIONS)]
    alike = ("well", "arrived", *WATCHED)
    found = [one(found=name) for name in FOUND]
    found += [one(is_stopped=True, found=name) for name in alike]
    found += [one((o,), found=name) for o in singly for name in (*alike, "restless")]
    found += [one((o,), is_stopped=True) for o in singly]
    found += [one(pair, is_stopped=stop) for pair in product(hand, hand) for stop in (False, True)]
    found += [one(is_changed=True), *(one((o,), is_changed=True) for o in singly)]
    return list(dict.fromkeys(found))

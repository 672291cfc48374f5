# SPDX-License-Identifier: BSD-3-Clause
"""All commands, one row each.

A row decides how the words are read, when the command is refused, what may begin without a
recording, what takes over from a motion under way, and the table of commands in the documents.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Final

from rst_control.commands import insert_withdraw, pull, release, tense
from rst_control.commands.camera_step import CAMERA_STEPS
from rst_control.commands.spec import (
    DISTANCE_STEP,
    FURTHEST_PULL,
    STOP,
    TENSION_STEP,
    TENSION_TARGET,
    CommandSpec,
    Load,
    Place,
    Role,
    TissueNeeded,
)
from rst_control.planning.plan import PhaseKind
from rst_control.types import State

ANY_STATE: Final = frozenset(State)
WHERE_SET_UP: Final = frozenset({State.STANDBY, State.ACTIVE, State.HALTED})
AT_REST_OR_PULLING: Final = frozenset({State.ACTIVE, State.MOVING})


def by_phrase(specs: Iterable[CommandSpec]) -> Mapping[str, CommandSpec]:
    """The table with these rows."""
    return {spec.phrase: spec for spec in specs}


COMMANDS: Final = by_phrase(
    (
        CommandSpec(
            "hey robot",
            "activates assistance; clears a latch, if the robot is at rest and healthy",
            role=Role.ACTIVATE,
            counts_in=ANY_STATE - {State.STOPPING},
            reply="ready",
        ),
        CommandSpec(
            "tense",
            "reaches the tissue, closes the jaws and pulls until the configured tension",
            load=Load.LOADS,
            tissue=TissueNeeded.NONE,
            phases=(PhaseKind.OPEN, PhaseKind.REACH, PhaseKind.CLOSE, PhaseKind.PULL),
            amounts=(TENSION_TARGET, FURTHEST_PULL),
            plan=tense.plan,
        ),
        CommandSpec(
            "release",
            "opens the jaws, then eases off",
            load=Load.EASES,
            tissue=TissueNeeded.HELD,
            place=Place.INSIDE_OR_HOLDING,
            phases=(PhaseKind.OPEN, PhaseKind.EASE),
            plan=release.plan,
        ),
        CommandSpec(
            "pull more",
            "one step further along the pull direction",
            counts_in=AT_REST_OR_PULLING,
            load=Load.LOADS,
            tissue=TissueNeeded.HELD,
            phases=(PhaseKind.STEP,),
            amounts=(TENSION_STEP, DISTANCE_STEP),
            plan=pull.more,
        ),
        CommandSpec(
            "pull less",
            "one step back",
            counts_in=AT_REST_OR_PULLING,
            load=Load.EASES,
            tissue=TissueNeeded.HELD,
            phases=(PhaseKind.STEP,),
            amounts=(TENSION_STEP, DISTANCE_STEP),
            plan=pull.less,
        ),
        CommandSpec(
            STOP,
            'brakes along its path, holds position, keeps the grip, latches until "hey robot"',
            role=Role.STOP,
            counts_in=ANY_STATE,
            reply='stops and holds; say "hey robot" to go on',
        ),
        CommandSpec(
            "terminate",
            "finishes braking, holds, keeps the grip, then is in standby; a latch stays",
            role=Role.TERMINATE,
            counts_in=ANY_STATE - {State.STANDBY},
            reply="finishes braking, holds and stands by",
        ),
        CommandSpec(
            "insert",
            "takes the tool from outside, or part-way in, to its working pose",
            load=Load.LOADS,
            tissue=TissueNeeded.NONE,
            place=Place.ANYWHERE,
            phases=(PhaseKind.ALIGN, PhaseKind.APPROACH, PhaseKind.INSERT),
            is_by_hand_only=True,
            plan=insert_withdraw.insert,
        ),
        CommandSpec(
            "withdraw",
            "straightens the tool and takes it out of the patient along its shaft",
            load=Load.EASES,
            tissue=TissueNeeded.NONE,
            place=Place.ANYWHERE,
            phases=(PhaseKind.ALIGN, PhaseKind.WITHDRAW),
            is_by_hand_only=True,
            plan=insert_withdraw.withdraw,
        ),
        CommandSpec(
            "grasp here",
            'moves nothing: "tense" takes the tissue where the tip is now',
            role=Role.SET_UP,
            counts_in=WHERE_SET_UP,
            tissue=TissueNeeded.NONE,
            is_by_hand_only=True,
        ),
        *CAMERA_STEPS,
    )
)


def markdown(commands: Mapping[str, CommandSpec] = COMMANDS) -> str:
    """The table of commands for the documents."""
    heads = (
        "command",
        "given",
        "counts in",
        "needs",
        "amounts",
        "unrecorded",
        "what the robot does",
    )
    rows = [" | ".join(("", *heads, "")).strip(), "|---" * len(heads) + "|"]
    rows += [" | ".join(("", *_cells(spec), "")).strip() for spec in commands.values()]
    return "\n".join(rows)


def _cells(spec: CommandSpec) -> tuple[str, ...]:
    needs = [] if spec.plan is None or spec.place is Place.ANYWHERE else [spec.place.value]
    needs += [spec.tissue.value] if spec.tissue is not TissueNeeded.ANY else []
    without = {Load.LOADS: "refused", Load.EASES: "goes on", Load.NEITHER: "goes on"}
    return (
        spec.phrase,
        "by hand only" if spec.is_by_hand_only else "by voice or hand",
        _states(spec.counts_in),
        ", ".join(needs),
        ", ".join(f"{a.name} [{a.unit}]: {a.meaning}" for a in spec.amounts),
        without[spec.load],
        spec.does,
    )


def _states(states: frozenset[State]) -> str:
    missing = [state.value for state in State if state not in states]
    if not missing:
        return "**any state**"
    if len(missing) == 1:
        return f"any state but {missing[0]}"
    return ", ".join(state.value for state in State if state in states)

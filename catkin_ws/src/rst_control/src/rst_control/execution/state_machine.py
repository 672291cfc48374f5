# SPDX-License-Identifier: BSD-3-Clause
"""The states of the controller and every way from one to the next, as a pure function of values.

Nothing here knows of time, joints or ROS, so that all sequences of events can be searched.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum

from rst_control.planning.plan import Rejected
from rst_control.types import Command, Reason

RETARGETS = (
    Command.PULL_MORE,
    Command.PULL_LESS,
)  # may be said again while the last one still moves


class State(Enum):
    """What the controller is doing."""

    STANDBY = "standby"  # at rest, assistance not activated
    ACTIVE = "active"  # at rest, ready for a command
    MOVING = "moving"
    STOPPING = "stopping"  # braking along the path
    HALTED = "halted"  # at rest, latched by a person's stop
    FAULTED = "faulted"  # at rest, latched by a watchdog


LATCHED = (State.HALTED, State.FAULTED)
IN_MOTION = (State.MOVING, State.STOPPING)


@dataclass(frozen=True)
class Life:
    """State of the controller, with what braking will lead to."""

    state: State = State.STANDBY
    is_active: bool = False  # "hey robot" was said, and no "terminate" since
    then: State = State.STANDBY  # where STOPPING ends
    reason: str = ""  # why it is halted or faulted, or will be once at rest

    @property
    def is_latched(self) -> bool:
        """Nothing moves until "hey robot"; true while still braking towards a latch, too."""
        return self.state in LATCHED or (self.state is State.STOPPING and self.then in LATCHED)


def refusal(life: Life, command: Command) -> Rejected | None:
    """Why the state forbids a command; None where it is allowed."""
    if command is Command.STOP:
        return None
    if command is Command.HEY_ROBOT:
        braking = life.state is State.STOPPING
        return (
            Rejected(Reason.NOT_AT_REST, "still braking; say it again at rest") if braking else None
        )
    if life.state is State.STANDBY:
        return Rejected(Reason.WRONG_MODE, 'in standby; say "hey robot" first')
    if command is Command.TERMINATE:
        return None
    return _motion_refusal(life, command)


def _motion_refusal(life: Life, command: Command) -> Rejected | None:
    if life.state is State.ACTIVE or (life.state is State.MOVING and command in RETARGETS):
        return None
    if life.state is State.MOVING:
        return Rejected(Reason.BUSY, 'busy moving; wait, or say "stop"')
    if life.state is State.STOPPING and not life.is_latched:
        return Rejected(Reason.NOT_AT_REST, "braking; wait until the robot is at rest")
    reason = Reason.FAULTED if State.FAULTED in (life.state, life.then) else Reason.HALTED
    return Rejected(reason, f'halted ({life.reason}); say "hey robot" to go on')


def activated(life: Life) -> Life:
    """After "hey robot" was accepted: any latch is cleared. A motion under way goes on."""
    if life.state in IN_MOTION:
        return life
    return Life(State.ACTIVE, is_active=True)


def started(life: Life) -> Life:
    """After a verified motion was accepted.

    Raises:
        ValueError: The state allows no motion.
    """
    if life.state not in (State.ACTIVE, State.MOVING):
        raise ValueError(f"motion from state {life.state.value}, allowed: active, moving")
    return replace(life, state=State.MOVING)


def at_rest(life: Life) -> Life:
    """After the motion reached its end, or braking came to rest."""
    match life.state:
        case State.MOVING:
            return replace(life, state=State.ACTIVE)
        case State.STOPPING:
            return replace(life, state=life.then)
        case _:
            return life


def stopped(life: Life, reason: str) -> Life:
    """After a stop by a person or program, in any state: halted, or braking towards it."""
    match life.state:
        case State.MOVING:
            return replace(life, state=State.STOPPING, then=State.HALTED, reason=reason)
        case State.STOPPING if life.then not in LATCHED:
            return replace(life, then=State.HALTED, reason=reason)
        case State.STANDBY | State.ACTIVE:
            return replace(life, state=State.HALTED, reason=reason)
        case _:
            return life  # the first cause stays the one that is told


def faulted(life: Life, reason: str) -> Life:
    """After a watchdog fired; in standby there is nothing to stop, and waking asks for health."""
    match life.state:
        case State.MOVING:
            return replace(life, state=State.STOPPING, then=State.FAULTED, reason=reason)
        case State.STOPPING if life.then is not State.FAULTED:
            return replace(life, then=State.FAULTED, reason=reason)
        case State.ACTIVE | State.HALTED:
            return replace(life, state=State.FAULTED, reason=reason)
        case _:
            return life


def failed(life: Life) -> Life:
    """After a motion could not reach its end, with nothing else wrong: braking, then active."""
    if life.state is State.MOVING:
        return replace(life, state=State.STOPPING, then=State.ACTIVE)
    return life


def terminated(life: Life) -> Life:
    """After "terminate": braking, then standby. A latch stays until "hey robot" clears it."""
    life = replace(life, is_active=False)
    match life.state:
        case State.MOVING:
            return replace(life, state=State.STOPPING, then=State.STANDBY)
        case State.STOPPING if life.then is State.ACTIVE:
            return replace(life, then=State.STANDBY)
        case State.ACTIVE:
            return replace(life, state=State.STANDBY)
        case _:
            return life

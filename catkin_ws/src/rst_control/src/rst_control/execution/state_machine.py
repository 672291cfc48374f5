# SPDX-License-Identifier: BSD-3-Clause
"""The states of the controller and every way from one to the next, as a pure function of values.

Nothing here knows of time, joints or ROS, so that all sequences of events can be searched.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum

from rst_control.planning.plan import Rejected
from rst_control.types import Cause, Command, Reason

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
class ControllerMode:
    """State of the controller, and the state that braking leads to."""

    state: State = State.STANDBY
    is_active: bool = False  # "hey robot" was said, and no "terminate" since
    mode_after: State = State.STANDBY  # where STOPPING ends
    cause: Cause | None = None  # why it is halted or faulted, or will be once at rest

    @property
    def reason(self) -> str:
        """The words of its cause; empty: there is none."""
        return self.cause.words if self.cause else ""

    @property
    def is_latched(self) -> bool:
        """Nothing moves until "hey robot"; true while still braking towards a latch, too."""
        return self.state in LATCHED or (
            self.state is State.STOPPING and self.mode_after in LATCHED
        )


def refusal(mode: ControllerMode, command: Command) -> Rejected | None:
    """Why the state forbids a command; None where it is allowed."""
    if command is Command.STOP:
        return None
    if command is Command.HEY_ROBOT:
        braking = mode.state is State.STOPPING
        return (
            Rejected(Reason.NOT_AT_REST, "still braking; say it again at rest") if braking else None
        )
    if mode.state is State.STANDBY:
        return Rejected(Reason.WRONG_MODE, 'in standby; say "hey robot" first')
    if command is Command.TERMINATE:
        return None
    return _motion_refusal(mode, command)


def _motion_refusal(mode: ControllerMode, command: Command) -> Rejected | None:
    if mode.state is State.ACTIVE or (mode.state is State.MOVING and command in RETARGETS):
        return None
    if mode.state is State.MOVING:
        return Rejected(Reason.BUSY, 'busy moving; wait, or say "stop"')
    if mode.state is State.STOPPING and not mode.is_latched:
        return Rejected(Reason.NOT_AT_REST, "braking; wait until the robot is at rest")
    return Rejected(Reason.HALTED, f'halted ({mode.reason}); say "hey robot" to go on')


def activated(mode: ControllerMode) -> ControllerMode:
    """After "hey robot" was accepted: any latch is cleared. A motion under way goes on."""
    if mode.state in IN_MOTION:
        return mode
    return ControllerMode(State.ACTIVE, is_active=True)


def started(mode: ControllerMode) -> ControllerMode:
    """After a verified motion was accepted.

    Raises:
        ValueError: The state allows no motion.
    """
    if mode.state not in (State.ACTIVE, State.MOVING):
        raise ValueError(f"motion from state {mode.state.value}, allowed: active, moving")
    return replace(mode, state=State.MOVING)


def at_rest(mode: ControllerMode) -> ControllerMode:
    """After the motion reached its end, or braking came to rest."""
    match mode.state:
        case State.MOVING:
            return replace(mode, state=State.ACTIVE)
        case State.STOPPING:
            return replace(mode, state=mode.mode_after)
        case _:
            return mode


def stopped(mode: ControllerMode, cause: Cause) -> ControllerMode:
    """After a stop by a person or program, in any state: halted, or braking towards it."""
    match mode.state:
        case State.MOVING:
            return replace(mode, state=State.STOPPING, mode_after=State.HALTED, cause=cause)
        case State.STOPPING if mode.mode_after not in LATCHED:
            return replace(mode, mode_after=State.HALTED, cause=cause)
        case State.STANDBY | State.ACTIVE:
            return replace(mode, state=State.HALTED, cause=cause)
        case _:
            return mode  # the first cause is the one reported


def faulted(mode: ControllerMode, cause: Cause) -> ControllerMode:
    """After a watchdog fired; in standby there is nothing to stop, and waking asks for health."""
    match mode.state:
        case State.MOVING:
            return replace(mode, state=State.STOPPING, mode_after=State.FAULTED, cause=cause)
        case State.STOPPING if mode.mode_after is not State.FAULTED:
            return replace(mode, mode_after=State.FAULTED, cause=cause)
        case State.ACTIVE | State.HALTED:
            return replace(mode, state=State.FAULTED, cause=cause)
        case _:
            return mode


def failed(mode: ControllerMode) -> ControllerMode:
    """After a motion could not reach its end, with nothing else wrong: braking, then active."""
    if mode.state is State.MOVING:
        return replace(mode, state=State.STOPPING, mode_after=State.ACTIVE)
    return mode


def terminated(mode: ControllerMode) -> ControllerMode:
    """After "terminate": braking, then standby. A latch stays until "hey robot" clears it."""
    mode = replace(mode, is_active=False)
    match mode.state:
        case State.MOVING:
            return replace(mode, state=State.STOPPING, mode_after=State.STANDBY)
        case State.STOPPING if mode.mode_after is State.ACTIVE:
            return replace(mode, mode_after=State.STANDBY)
        case State.ACTIVE:
            return replace(mode, state=State.STANDBY)
        case _:
            return mode

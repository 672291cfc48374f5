# SPDX-License-Identifier: BSD-3-Clause
"""Every way from one mode of the controller to the next, as pure functions of values.

Nothing here knows of time, joints or ROS, so that all sequences of events can be searched.
`commands/preconditions.py` has the rule which command counts in which state.
"""

from __future__ import annotations

from dataclasses import replace

from rst_control.types import IN_MOTION, LATCHED, Cause, ControllerMode, State


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

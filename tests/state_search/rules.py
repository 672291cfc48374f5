# SPDX-License-Identifier: BSD-3-Clause
"""What no tick of the controller may do, whatever happened before it."""

import numpy as np

from rst_control.commands.table import COMMANDS
from rst_control.kinematics.configuration import planning_joints, robot_joints
from rst_control.types import State
from tests.state_search.inputs import FOUND, LATE, WATCHED

# A robot at rest does not mind who has left; without a master it wakes for nobody.
HEALTHY = (
    "well",
    "arrived",
    "failing",
    "off trocar",
    "too tense",
    "slipped",
    "off course",
    "no owner",
)
AT_REST = (State.STANDBY, State.ACTIVE, State.HALTED, State.FAULTED)


def objection(before, given, edge, held):
    """Which of the controller's invariants an edge breaks; empty: none.

    Args:
        before: State that it leaves.
        given: Input that was carried out.
        edge: What it led to.
        held: Set-points before and after.
    """
    found = _motion(before, given, edge) or _latch(before, given, edge)
    return found or _rest(before, edge, held) or _number(before, edge)


def _motion(before, given, edge):
    was, state, is_active = before[0], *edge.to[:2]
    if edge.started is not None and not edge.started.is_fresh:
        return f"{edge.started.command.phrase} set off without a path verified here"
    if edge.started is not None and was not in (State.ACTIVE, State.MOVING):
        return f"{edge.started.command.phrase} set off from {was.value}"
    if state is not State.MOVING:
        return ""
    if was not in (State.ACTIVE, State.MOVING):
        return f"from {was.value} to moving"
    if not is_active:
        return "moving while not activated"
    is_there = before[4] == "away" and given.found == "off course"  # where its set-point is, too
    is_well = is_there or given.found not in (*WATCHED, "crash")
    return "" if is_well else f"moving although {given.found}"


def _latch(before, given, edge):
    was, is_held = is_latched(before[0], before[2]), is_latched(edge.to[0], edge.to[2])
    if given.is_stopped and not is_held:
        return f"a stop led to {edge.to[0].value}"
    if not was or is_held:
        return ""
    is_asked = any(order.command is COMMANDS["hey robot"] for order in given.orders)
    was_waiting = not before[-1]  # an earlier one, for the robot to be well
    if not (is_asked or was_waiting):
        return f"the latch was lifted by {given}"
    if before[0] is State.STOPPING:
        return "the latch was lifted while braking"
    return "" if given.found in (*LATE, *HEALTHY) else f"the latch was lifted, {given.found}"


def _rest(before, edge, held):
    """At rest the set-point stays, but for being taken anew from the measured joints."""
    if edge.started is not None or before[0] not in AT_REST or edge.to[0] not in AT_REST:
        return ""
    was, now = held
    if was is None or now is None or was is now:
        return ""
    if any(m is not None and _is_taken_from(m, was, now) for m in FOUND.values()):
        return ""
    return f"the set-point moved from {before[0].value} to {edge.to[0].value}"


def _is_taken_from(found, was, held):
    """As measured, but for jaws with tissue between them, which stay sent further to close."""
    if held is found.position or not found.gripped:
        return held is found.position
    q, opening = planning_joints(found.position)
    sent = planning_joints(was)[1]
    return sent < opening and np.array_equal(held, robot_joints(q, sent))


def _number(before, edge):
    """What verification reads has not changed, or the number that says so has."""

    def seen(key):
        state, is_active, mode_after, moving, *held_and_grasp = key[:6]
        return state, is_active, mode_after, moving is None, held_and_grasp

    if edge.has_changed or seen(before) == seen(edge.to):
        return ""
    return "the situation changed, and its number did not"


def is_latched(state, mode_after):
    """Halted or faulted, or braking towards it."""
    latched = (State.HALTED, State.FAULTED)
    return state in latched or (state is State.STOPPING and mode_after in latched)

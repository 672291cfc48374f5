# SPDX-License-Identifier: BSD-3-Clause
"""What the search over all states says of the controller holds with real paths and set-points.

The search (`test_state_search.py`) leaves to chance how long a phase takes. Here the
same inputs go to a controller with its real planner and motion, on the robot without physics: every
way in which an input changes the mode of the controller is taken at least once.
"""

import numpy as np
import pytest

from rst_control.commands.table import COMMANDS
from rst_control.execution.orders import Order
from rst_control.types import IN_MOTION, Cause, Reason, State
from tests.state_search.controller import explore
from tests.state_search.inputs import Given, one
from tests.unit.rst_control.support.executor_rig import Rig
from tests.unit.rst_control.support.situations import request

HEY, TERMINATE, TENSE = (
    Given(c) for c in (COMMANDS["hey robot"], COMMANDS["terminate"], COMMANDS["tense"])
)
STALE = Given(COMMANDS["tense"], is_fresh=False)
UNDER_WAY = 0.3  # [s] after which a motion is so fast that it does not stop within a few ticks
BROKEN = ("stale", "gone", "robot fault", "crash")
STEPS = [
    *(one((given,)) for given in (HEY, TERMINATE, TENSE, STALE)),
    *(one(is_stopped=True), one((HEY,), is_stopped=True)),
    *(one(found=name) for name in ("well", "arrived", *BROKEN)),
]


def mode_of(key):
    state, is_active, then = key[:3]
    return state, is_active, then if state is State.STOPPING else None


def ways():
    """For each change of mode by an input, the shortest way that ends with it."""
    graph, found = explore(STEPS), {}
    for key, edges in graph.edges.items():
        for step, edge in edges.items():
            change, way = (mode_of(key), step, mode_of(edge.to)), (*graph.way[key], step)
            if change not in found or len(way) < len(found[change]):
                found[change] = way
    return graph, list(found.values())


GRAPH, WAYS = ways()


def do(rig, step, expected):
    """Carry an input out; an arrival is waited for where the search says that it ends a motion."""
    is_off = rig.state is not State.MOVING
    for given in step.orders:
        if given.is_fresh:
            rig.queue.take(given.command.phrase, "test")
        else:
            plan = rig.context.verify(request("tense"), rig.home).plan
            rig.executor.post(
                Order(plan, rig.view.serial - 1, rig.executor.latches, stale=lambda: None)
            )
    if step.is_stopped:
        rig.executor.stop(Cause(Reason.STOP_TOPIC, "test"))
    if (waiting := rig.queue.next(0.0)) is not None:
        rig.queue.check(waiting)
    if step.found in BROKEN:
        break_once(rig, step.found)
    elif step.found == "arrived" and rig.state in IN_MOTION and expected[0] not in IN_MOTION:
        rig.rest(limit=30.0)
    else:
        rig.tick()
    if rig.executor._setpoint_state.held is None:
        rig.robot.hold()  # as the node does where no set-point is sent
    if is_off and rig.state is State.MOVING:
        rig.run(UNDER_WAY)


def break_once(rig, what):
    """One tick at which something is broken."""
    robot = rig.robot
    if what == "crash":
        rig.executor.crashed(ArithmeticError("x"))
        return
    if what == "stale":
        robot.freeze()
        rig.now += 0.03
    robot.is_connected, robot.fault = what != "gone", "x" * (what == "robot fault")
    rig.tick()
    robot.is_connected, robot.fault = True, ""
    robot.thaw()


@pytest.mark.parametrize("way", WAYS, ids=lambda way: "; ".join(map(str, way)))
def test_a_controller_with_real_paths_goes_the_way_that_the_search_went(way):
    rig, key = Rig(), next(iter(GRAPH.edges))
    rig.tick()
    rig.home = awake_at_home()
    for step in way:
        key = GRAPH.edges[key][step].to
        do(rig, step, mode_of(key))
        mode = rig.executor._mode  # a tick that raised shows no view
        then = mode.mode_after if mode.state is State.STOPPING else None
        assert (mode.state, mode.is_active, then) == mode_of(key), str(step)
    fastest = np.append(rig.config.limits.layers[0].arm_velocity, [1.5, 1.5, 1.5]) + 1e-6
    assert all((np.abs(s.velocity) <= fastest).all() for s in rig.sent if s is not None)


def awake_at_home():
    """A situation in which "tense" is verified."""
    rig = Rig().awake()
    return rig.view.situation(rig.now)

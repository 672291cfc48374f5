# SPDX-License-Identifier: BSD-3-Clause
"""Whatever is said and breaks, in any order: nothing moves but by a command of an active system."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from rst_control.commands.table import COMMANDS
from rst_control.types import IN_MOTION, Cause, Reason, State
from tests.unit.rst_control.support.executor_rig import Rig

EVENTS = {
    "freeze": lambda rig: rig.robot.freeze(),
    "thaw": lambda rig: rig.robot.thaw(),
    "disconnect": lambda rig: setattr(rig.robot, "is_connected", False),
    "reconnect": lambda rig: setattr(rig.robot, "is_connected", True),
    "robot fault": lambda rig: (setattr(rig.robot, "fault", "x"), rig.robot.hold()),
    "push": lambda rig: rig.robot.push(np.full(10, 2e-2)),
    "crash": lambda rig: rig.executor.crashed(ArithmeticError("x")),
    "heartbeat": lambda rig: rig.executor.heartbeat(rig.now),
    "stop twice": lambda rig: [rig.executor.stop(Cause(Reason.STOP_TOPIC, w)) for w in "ab"],
    "clock jumps": lambda rig: setattr(rig, "now", rig.now + 0.3),
}
SPOKEN = [f"spoken {c.phrase}" for c in COMMANDS.values()]
WAITS = (0.0, 0.02, 0.3, 2.0)
STEPS = st.tuples(
    st.sampled_from([*(c.phrase for c in COMMANDS.values()), *SPOKEN, *EVENTS]),
    st.sampled_from(WAITS),
)
LIKELY = [("hey robot", 0.0), ("tense", 2.0)]


class Watch:
    """Looks at every tick of a rig."""

    def __init__(self, rig):
        self.rig, self.tick = rig, rig.tick
        self.speed = np.append(rig.config.limits.layers[0].arm_velocity, [1.5, 1.5, 1.5])
        rig.tick = self.look

    def look(self):
        before, last = self.rig.view, self.rig.sent[-1] if self.rig.sent else None
        setpoint = self.tick()
        after = self.rig.view
        if setpoint is not None and last is not None:
            self.check_step(before, after, last, setpoint)
        if after.mode.state is State.MOVING:
            assert after.mode.is_active
            assert before.mode.state in (State.MOVING, State.ACTIVE, State.STANDBY, *LATCHED)
        return setpoint

    def check_step(self, before, after, last, setpoint):
        moved = np.abs(setpoint.position - last.position)
        was_in_motion = before.mode.state in IN_MOTION or after.mode.state in IN_MOTION
        if not was_in_motion:
            assert not setpoint.velocity.any()
            taken_anew = np.array_equal(setpoint.position, after.measurement.position)
            assert moved.max() == 0.0 or taken_anew
            return
        assert (np.abs(setpoint.velocity) <= self.speed + 1e-6).all()
        assert (moved <= 5 * 0.002 * self.speed + 1e-6).all()


LATCHED = (State.HALTED, State.FAULTED)


def perform(rig, step):
    name, wait = step
    if name in EVENTS:
        EVENTS[name](rig)
        rig.tick()
    else:
        rig.give(name.removeprefix("spoken "), spoken=name.startswith("spoken "))
    rig.run(wait)


@given(start=st.booleans(), steps=st.lists(STEPS, min_size=1, max_size=8))
@settings(max_examples=20, deadline=None)
def test_nothing_moves_but_by_a_command_of_an_active_system(start, steps):
    rig = Rig().run(0.01)
    Watch(rig)
    for step in [*(LIKELY if start else []), *steps]:
        perform(rig, step)


@given(steps=st.lists(STEPS.filter(lambda s: "hey robot" not in s[0]), max_size=8))
@settings(max_examples=12, deadline=None)
def test_without_hey_robot_the_robot_stays_where_it_is(steps):
    rig = Rig().run(0.01)
    pushes = [s for s in steps if s[0] == "push"]
    start = rig.joints
    for step in steps:
        perform(rig, step)
        assert rig.state not in IN_MOTION
    assert pushes or np.array_equal(rig.joints, start)


@given(
    before=st.lists(STEPS, max_size=3),
    after=st.lists(STEPS.filter(lambda s: "hey robot" not in s[0]), max_size=6),
)
@settings(max_examples=12, deadline=None)
def test_after_a_stop_nothing_moves_until_hey_robot(before, after):
    rig = Rig().run(0.01)
    for step in [*LIKELY, *before]:
        perform(rig, step)
    rig.say("stop")
    rig.rest()
    for step in after:
        perform(rig, step)
        assert rig.state in LATCHED

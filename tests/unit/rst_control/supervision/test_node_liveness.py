# SPDX-License-Identifier: BSD-3-Clause
"""A motion lasts as long as those are there without whom it may not go on."""

import pytest

from rst_control.host.processes import ENDED, STOPPED
from rst_control.supervision.node_liveness import MASTER
from rst_control.types import State
from tests.unit.rst_control.support.executor_rig import Rig

PANEL = "/panel"


def moving(owner):
    rig = Rig().awake()
    rig.say("tense", owner=owner)
    rig.run(0.2)
    assert rig.state is State.MOVING
    return rig


@pytest.mark.parametrize("how", [ENDED, STOPPED])
def test_who_asked_for_a_motion_and_is_lost_stops_it(how):
    rig = moving(PANEL)
    rig.liveness.report({PANEL: how})
    rig.tick()
    assert rig.state is State.STOPPING
    rig.until(lambda: rig.state is State.FAULTED)
    assert rig.view.mode.reason == f"/panel {how} during its motion"


def test_it_goes_on_when_somebody_else_is_lost():
    rig = moving(PANEL)
    rig.liveness.report({"/other": ENDED})
    rig.run(0.1)
    assert rig.state is State.MOVING


def test_a_motion_that_nobody_has_to_watch_goes_on():
    rig = moving("")
    rig.liveness.report({PANEL: ENDED, "": ENDED})
    rig.run(0.1)
    assert rig.state is State.MOVING


def test_nothing_goes_on_by_itself_when_it_is_back():
    rig = moving(PANEL)
    rig.liveness.report({PANEL: STOPPED})
    rig.until(lambda: rig.state is State.FAULTED)
    rig.liveness.report({})
    before = rig.view.setpoint
    rig.run(1.0)
    assert rig.state is State.FAULTED
    assert (rig.view.setpoint == before).all()
    rig.say("hey robot")
    rig.say("tense", owner=PANEL)


def test_who_is_lost_already_sets_nothing_off():
    rig = Rig().awake()
    rig.liveness.report({PANEL: ENDED})
    pending = rig.give("tense", owner=PANEL)
    assert pending.reply.result().message == "/panel ended"
    assert rig.state is State.ACTIVE
    rig.say("tense")  # by hand it may


def test_without_the_master_all_brakes_and_nothing_begins():
    rig = moving("")
    rig.liveness.report({MASTER: ENDED})
    rig.tick()
    assert rig.state is State.STOPPING
    rig.until(lambda: rig.state is State.FAULTED)
    assert rig.view.mode.reason.startswith("the ROS master ended")
    for words in ("hey robot", "tense"):
        assert not rig.give(words).reply.result().accepted
    rig.liveness.report({})
    rig.run(0.5)
    assert rig.state is State.FAULTED
    rig.say("hey robot")


def test_at_rest_without_the_master_the_grip_is_kept_by_the_same_set_point():
    rig = moving("")
    rig.until(lambda: not rig.view.is_moving)
    assert rig.view.grasp is not None
    before = rig.view.setpoint
    rig.liveness.report({MASTER: STOPPED})
    rig.run(0.2)
    assert rig.state is State.FAULTED
    rig.liveness.report({})
    rig.run(0.2)
    assert all((sent.position == before).all() for sent in rig.sent[-200:])


def test_a_stop_is_taken_without_the_master():
    rig = moving("")
    rig.say("stop")
    rig.liveness.report({MASTER: STOPPED})
    rig.until(lambda: rig.view.mode.is_latched and not rig.view.is_moving)


def test_braking_to_a_latch_keeps_the_first_cause_while_the_heartbeat_pauses():
    rig = Rig()
    rig.run(0.3)
    rig.executor.heartbeat(rig.now)
    rig.say("hey robot", spoken=True)
    rig.executor.heartbeat(rig.now)
    rig.say("tense", spoken=True)
    rig.run(0.1)
    rig.say("stop")
    rig.executor.heartbeat(rig.now - 10.0)
    rig.until(lambda: not rig.view.is_moving)
    assert rig.state is State.HALTED

# SPDX-License-Identifier: BSD-3-Clause
import numpy as np
import pytest

from rst_control.commands.request import Accepted, Plan
from rst_control.execution.motion import MotionMaker, OffPath
from rst_control.planning.plan import Phase, PhaseKind
from rst_control.types import Reason, Rejected
from tests.unit.rst_control.support.executor_rig import Rig, shared
from tests.unit.rst_control.support.situations import request


def tense_plan(rig):
    verify = shared()[2].verify
    decision = verify(request("tense"), rig.view.situation(rig.now))
    assert isinstance(decision, Accepted)
    return decision.plan


@pytest.fixture
def rig():
    return Rig().awake()


@pytest.fixture
def maker(rig):
    return MotionMaker(rig.config.controller)


def test_a_plan_that_begins_elsewhere_is_refused(rig, maker):
    plan = tense_plan(rig)
    reach = Plan(plan.command, plan.words, tuple(p for p in plan.phases if p.path is not None))
    refused = maker.make(reach, rig.joints + 0.01, None, None, rig.now)
    assert isinstance(refused, Rejected)
    assert refused.reason is Reason.NOT_AT_REST and "away" in refused.words


def test_a_later_phase_that_would_begin_elsewhere_is_an_error(rig, maker):
    plan = tense_plan(rig)
    pull = next(p for p in plan.phases if p.kind is PhaseKind.PULL)
    jaws = Phase(PhaseKind.OPEN, opening=0.01)
    motion = maker.make(Plan(plan.command, "", (jaws, pull)), rig.joints, None, None, rig.now)
    with pytest.raises(OffPath):
        for _ in range(2000):
            motion.advance(1, rig.robot.measured_js(), rig.now)


def test_no_further_phase_begins_after_braking(rig, maker):
    motion = maker.make(tense_plan(rig), rig.joints, None, None, rig.now)
    measured = rig.robot.measured_js()
    for _ in range(5):
        motion.advance(1, measured, rig.now)
    motion.brake()
    for _ in range(1000):
        held, velocity = motion.advance(1, measured, rig.now)
    assert motion.is_done and motion.phase is PhaseKind.OPEN
    np.testing.assert_array_equal(velocity, np.zeros(10))
    np.testing.assert_array_equal(held[:8], rig.joints[:8])


def test_progress_grows_from_zero_to_one_in_every_phase(rig):
    pending = rig.say("tense")
    seen = {}
    while not pending.ended.done():
        rig.tick()
        if rig.view.motion is not None:
            seen.setdefault(rig.phase, []).append(rig.view.motion.progress)
    assert list(seen) == ["open", "reach", "close", "pull"]
    for kind in ("open", "close"):
        assert seen[kind][0] < 0.1 and seen[kind][-1] > 1.0 - 1e-9
        assert (np.diff(seen[kind]) >= -1e-9).all()
    assert all(0.0 <= p <= 1.0 for values in seen.values() for p in values)


def test_a_stop_while_the_jaws_close_leaves_no_pull_behind(rig):
    rig.say("tense")
    rig.until(lambda: rig.phase == "close" and rig.view.is_tissue_held)
    assert rig.view.tension_target == rig.config.controller.tension.initial
    rig.stop()
    rig.rest()
    rig.tick()
    assert (rig.view.tension_target, rig.view.grasp.s) == (0.0, 0.0)

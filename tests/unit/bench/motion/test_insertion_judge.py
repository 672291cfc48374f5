# SPDX-License-Identifier: BSD-3-Clause
"""The judge of insertions objects to what is wrong; that it does not to what is right, see
tests/property/test_insertion_oracle.py.
"""

from dataclasses import replace

import numpy as np
import pytest

from bench.motion.bullet.witness import BulletWitness
from bench.motion.insertion import InsertionJudge
from rst_control.planning.free_space import Approach
from rst_control.planning.insertion import Insertion
from rst_control.planning.plan import PhaseKind
from rst_control.planning.planner import along

SAMPLES = 40


@pytest.fixture
def judge(planner, motion_config):
    with BulletWitness(motion_config) as witness:
        yield InsertionJudge(planner, witness)


@pytest.fixture(scope="module")
def slide(planner, home):
    """Straight out of the trocar, as it should be."""
    return along(planner, PhaseKind.WITHDRAW, Insertion(planner).withdraw(home)[-1].path, 0.01)


def straight(planner, kind, a, b):
    patient = planner.patient
    leg = Approach(planner.model, planner.limits, patient.outside, patient.outward).leg(a, b)
    return along(planner, kind, leg, 0.02)


def objection(judge, phase):
    return judge.objection(phase.path.start, (phase,), SAMPLES)


def test_a_good_phase_is_approved(judge, slide):
    assert objection(judge, slide) == ""


def test_an_approach_below_the_surface_is_not(judge, slide):
    assert "mm from the surface" in objection(judge, replace(slide, kind=PhaseKind.APPROACH))


def test_a_way_in_that_leaves_the_trocar_is_not(judge, planner, slide):
    crooked = straight(planner, PhaseKind.INSERT, slide.path.end, slide.path.start)
    assert "um off the trocar" in objection(judge, crooked)


def test_a_tool_bent_in_the_trocar_is_not(judge, planner, slide):
    bent = slide.path.evaluate(0.7 * slide.path.length).q
    straightened = bent.copy()
    bent[7] = 0.1
    assert "bent in the trocar" in objection(
        judge, straight(planner, PhaseKind.ALIGN, bent, straightened)
    )


def test_an_arm_too_near_the_patient_is_not(judge, planner, home):
    low = home.copy()
    low[1] += 1.2
    assert "arm -" in objection(judge, straight(planner, PhaseKind.APPROACH, low, home))


def test_joints_too_fast_or_too_hard_are_not(judge, slide):
    assert "too fast" in objection(judge, replace(slide, speed=1.0, acceleration=4.0))
    assert "too hard" in objection(judge, replace(slide, speed=0.05, acceleration=4.0))


def test_a_joint_beyond_its_limit_is_not(judge, planner, slide):
    beyond = slide.path.end.copy()
    beyond[5] = planner.limits.upper[5] + 0.1
    phase = straight(planner, PhaseKind.APPROACH, slide.path.end, beyond)
    assert "beyond a joint limit" in objection(judge, phase)


def test_phases_that_do_not_join_are_not(judge, slide):
    assert "away from" in judge.objection(slide.path.start + 0.01, (slide,), SAMPLES)
    assert np.isfinite(judge.worst_inside((slide,), 20.0))

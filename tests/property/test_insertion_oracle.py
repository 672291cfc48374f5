# SPDX-License-Identifier: BSD-3-Clause
"""Insertion from many places outside and withdrawal, judged by PyBullet's kinematics."""

import numpy as np
import pytest

from bench.common.rig import random_poses
from bench.motion.bullet.witness import BulletWitness
from bench.motion.insertion import InsertionJudge, outside_starts, situation
from rst_control.errors import Infeasible
from rst_control.planning.plan import PhaseKind
from rst_control.types import Rejected
from tests.unit.rst_control.support.situations import request

STARTS = 40  # whose insertion is planned
JUDGED = 3  # of so many plans one is judged in full; the bench judges all of its own
SAMPLES = 25  # places of each phase
RATE = 250.0  # [Hz] of the samples of the way in, 0.04 mm apart; the bench takes 10 kHz
RCM_WORST = 2e-6  # [m], of which 1 um is PyBullet's single precision


@pytest.fixture(scope="module")
def judge(planner, motion_config):
    with BulletWitness(motion_config) as witness:
        yield InsertionJudge(planner, witness)


@pytest.fixture(scope="module")
def decisions(planner, verify):
    starts = outside_starts(planner, STARTS, seed=21)
    return [(q, verify(request("insert"), situation(q))) for q in starts]


def test_insertion_from_anywhere_outside_is_planned_or_refused_with_a_reason(decisions):
    refused = [d for _, d in decisions if isinstance(d, Rejected)]
    assert len(refused) <= 0.1 * STARTS
    assert all("blocked" in decision.words for decision in refused)


def test_plans_keep_trocar_surface_joint_limits_and_their_derivatives(judge, decisions):
    plans = [(q, d.plan) for q, d in decisions if not isinstance(d, Rejected)]
    assert len(plans) > 0.9 * STARTS
    for q, plan in plans[::JUDGED]:
        assert judge.objection(q, plan.phases, SAMPLES) == ""


def test_approaches_differ_but_all_lead_through_the_same_trocar(planner, judge, decisions):
    plans = [d.plan for _, d in decisions if not isinstance(d, Rejected)]
    counts = {sum(p.kind is PhaseKind.APPROACH for p in plan.phases) for plan in plans}
    assert 1 in counts and max(counts) > 2
    ends = np.array([plan.phases[-1].path.end for plan in plans])
    turns = planner.limits.turns_towards(ends, ends[0])  # the shortest way may end in another turn
    np.testing.assert_allclose(ends + turns, np.tile(ends[0], (len(ends), 1)), atol=1e-12)
    assert judge.worst_inside(plans[0].phases, RATE) < RCM_WORST


def test_withdrawals_from_anywhere_inside_keep_them_as_well(planner, judge, verify, home):
    q, judged = home, 0
    for pose in random_poses(planner.config, 20, seed=22):
        try:
            q = planner.leg(q, pose).end
        except Infeasible:
            continue
        decision = verify(request("withdraw"), situation(q))
        assert not isinstance(decision, Rejected), decision.words
        assert judge.objection(q, decision.plan.phases, SAMPLES) == ""
        judged += 1
    assert judged > 6

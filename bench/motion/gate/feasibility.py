# SPDX-License-Identifier: BSD-3-Clause
"""Item 5: the feasibility gate: what is accepted succeeds, a refusal has a true reason."""

from __future__ import annotations

import time
from collections import Counter
from dataclasses import dataclass, field, replace

import numpy as np

from bench.common.rig import Rig
from bench.motion.gate.cases import Case, Cases
from bench.motion.gate.oracle import GateJudge
from rst_control.commands.request import Accepted
from rst_control.config import MotionConfig, SimulationConfig
from rst_control.types import Reason, Rejected
from support.figures import Figure

GEOMETRIC = 0.17  # share of the cases that are scenes anywhere about the workspace
NEAR = 0.05  # share with the tool near the arm, or the arm near a singularity
FEASIBLE = GEOMETRIC + NEAR + 0.40  # up to here, commands that nothing speaks against
NODES = (9, 9)  # of the tissue of executed commands
SHOWN = 8  # kinds of wrong answers that are named


@dataclass
class GateTally:
    """What became of all cases."""

    times: list[float] = field(default_factory=list)  # [s]
    accepted: int = 0
    reasons: Counter[str] = field(default_factory=Counter)
    bad_plans: Counter[str] = field(default_factory=Counter)
    untrue: Counter[str] = field(default_factory=Counter)
    passed: list[Case] = field(default_factory=list)  # accepted "tense"

    @property
    def refused(self) -> int:
        """Number of refusals."""
        return sum(self.reasons.values())


def measure(
    config: MotionConfig, simulation: SimulationConfig, count: int, executed: int
) -> list[Figure]:
    """Verify random commands, let KDL judge the answers, and carry some of the accepted out.

    Args:
        config: Settings of the controller.
        simulation: Settings of the simulated robot.
        count: Cases, about half of them infeasible.
        executed: Accepted commands that are carried out.
    """
    cases, judge, tally = Cases(config, seed=5), GateJudge(), GateTally()
    rng = np.random.default_rng(55)
    for _ in range(count):
        draw = rng.uniform()
        if draw < GEOMETRIC:
            case = cases.geometric()
        elif draw < GEOMETRIC + NEAR:
            case = cases.near()
        else:
            case = cases.feasible() if draw < FEASIBLE else cases.infeasible()
        _judge_case(case, judge, tally)
    ended = [_execute(case, simulation) for case in tally.passed[:executed]]
    return _figures(tally, [words for words in ended if words], len(ended))


def _judge_case(case: Case, judge: GateJudge, tally: GateTally) -> None:
    begin = time.perf_counter()
    decision = case.decide()
    tally.times.append(time.perf_counter() - begin)
    if isinstance(decision, Accepted):
        tally.accepted += 1
        wrong = judge.objection(case, decision.plan)
        if case.expected is not None:
            wrong = f"not refused for {case.expected.value}"
        if wrong:
            tally.bad_plans[wrong] += 1
        elif case.request.words == "tense":
            tally.passed.append(case)
        return
    tally.reasons[decision.reason.value] += 1
    if not _is_true(case, decision, judge):
        asked = case.expected.value if case.expected else "none"
        tally.untrue[f"{case.request.words}: {decision.reason.value}, not {asked}"] += 1


def _is_true(case: Case, decision: Rejected, judge: GateJudge) -> bool:
    if case.expected is not None and decision.reason is not case.expected:
        return False
    if case.expected is None or decision.reason is Reason.RCM_TOLERANCE:
        return not case.is_feasible and judge.is_true(case, decision.reason)
    return True


def _execute(case: Case, simulation: SimulationConfig) -> str:
    """Carry out "tense", then "pull less" and "release"; returns what went wrong."""
    tissue = replace(case.config.scene.tissue, nodes=NODES)
    config = replace(case.config, scene=replace(case.config.scene, tissue=tissue))
    with Rig(config, simulation, is_light=True) as rig:
        rig.wake()
        for words, amount in (("tense", case.request.tension), ("pull less", 0.1), ("release", 0)):
            wrong = rig.finish(words, amount)
            if wrong:
                return f"{words} {wrong}"
    return ""


def _figures(tally: GateTally, failed: list[str], executed: int) -> list[Figure]:
    p50, p99 = np.percentile(tally.times, (50, 99))
    kinds = ", ".join(f"{name} {n}" for name, n in tally.reasons.most_common())
    bad, untrue = sum(tally.bad_plans.values()), sum(tally.untrue.values())
    return [
        Figure("gate: refused", float(tally.refused), f"of {len(tally.times)}", note=f"({kinds})"),
        Figure(
            "gate: accepted plans that break a limit, by KDL",
            float(bad), "", 0.0, note=_named(tally.bad_plans, f"of {tally.accepted}"),
        ),
        Figure(
            "gate: accepted commands that failed in execution",
            float(len(failed)), "", 0.0, note=_named(Counter(failed), f"of {executed} carried out"),
        ),
        Figure(
            "gate: refusals without their true reason",
            float(untrue), "", 0.0, note=_named(tally.untrue, f"of {tally.refused}"),
        ),
        Figure("gate: time median", p50 * 1e3, "ms"),
        Figure("gate: time p99", p99 * 1e3, "ms", 20.0),
        Figure("gate: time max", max(tally.times) * 1e3, "ms"),
    ]  # fmt: skip


def _named(counter: Counter[str], of: str) -> str:
    found = "; ".join(f"{n} x {words}" for words, n in counter.most_common(SHOWN))
    return f"({of}{': ' if found else ''}{found})"

# SPDX-License-Identifier: BSD-3-Clause
"""Plans "pull more" and "pull less": a step of tension, or of distance where none is trusted."""

from __future__ import annotations

from dataclasses import replace
from math import inf

from rst_control.commands import pull_by_distance
from rst_control.commands.held_tissue import held
from rst_control.commands.pull_by_distance import DistanceForTension
from rst_control.commands.request import Accepted, PlanningContext, Request
from rst_control.commands.tension_limits import (
    bounded,
    ease_refusal,
    present_refusal,
    pulled_before,
    room_refusal,
    target_refusal,
)
from rst_control.planning.plan import Grasp, PhaseKind
from rst_control.types import Rejected


def more(context: PlanningContext) -> Accepted | Rejected:
    """Plan one step further along the pull."""
    return _plan(context, is_more=True)


def less(context: PlanningContext) -> Accepted | Rejected:
    """Plan one step back."""
    return _plan(context, is_more=False)


def _plan(context: PlanningContext, is_more: bool) -> Accepted | Rejected:
    by_distance = DistanceForTension(context.config.tension)
    if _asks_distance(context) or by_distance.why(context.measured):
        return pull_by_distance.plan(context, is_more)
    return _plan_tension(context, is_more)


def _asks_distance(context: PlanningContext) -> bool:
    request: Request = context.request
    if request.tension or request.distance:
        return not request.tension
    return context.config.tension.step_by == "distance"


def _plan_tension(context: PlanningContext, is_more: bool) -> Accepted | Rejected:
    config, (grasp, seats) = context.config.tension, held(context)
    before = pulled_before(grasp, context.situation.pulled)
    furthest = DistanceForTension(config).furthest(grasp, before, "")
    is_moving = context.situation.is_moving
    unable = None if is_more or is_moving else ease_refusal(grasp, furthest, before)
    if furthest == -inf and (is_more or unable is not None):
        return pull_by_distance.unseen("", config)
    step = context.request.tension or config.step_tension
    base = _base_tension(context, grasp)
    if not is_more and not is_moving:  # tissue that relaxed within the tolerance is not pulled on
        base = base if base - step < context.measured.tension else context.measured.tension
    # Less, from above what is allowed, leads all the way back to it.
    target = base + step if is_more else min(base - step, config.maximum)
    refusal = target_refusal(target, config) or unable
    if is_more:
        refusal = refusal or present_refusal(context.measured, config)
        refusal = refusal or room_refusal(grasp, furthest, before)
    if refusal is not None:
        return refusal
    target = bounded(target, config)
    phase = context.along(PhaseKind.STEP, grasp.pull, context.config.speed.pull_speed)
    phase = replace(phase, start=grasp.s, target=max(furthest, grasp.s), tension=target)
    words = f"pulls {'more' if is_more else 'less'}: {base:.2f} N to {target:.2f} N"
    return context.accept(words, (*seats, phase), replace(grasp, tension=target))


def _base_tension(context: PlanningContext, grasp: Grasp) -> float:
    """What a step starts from [N]: the target while pursued or held, else what is measured."""
    target, measured = grasp.tension, context.measured.tension
    if target is None:
        return measured
    is_held = abs(measured - target) <= 2.0 * context.config.tension.tolerance
    return target if context.situation.is_moving or is_held else measured

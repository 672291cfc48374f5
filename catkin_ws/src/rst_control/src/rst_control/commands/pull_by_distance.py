# SPDX-License-Identifier: BSD-3-Clause
"""Plans a pull by distance, and how far one may go where no tension can be relied on."""

from __future__ import annotations

from dataclasses import replace
from math import inf

from rst_control.commands.held_tissue import held
from rst_control.commands.request import Accepted, PlanningContext
from rst_control.commands.tension_limits import (
    ROUNDING,
    predicted_refusal,
    present_refusal,
    pulled_before,
    too_far,
)
from rst_control.config import TensionConfig
from rst_control.planning.plan import Grasp, PhaseKind
from rst_control.types import Measurement, Reason, Rejected


class DistanceForTension:
    """Turns tensions into distances from the grasp.

    Tissue no stiffer than `blind_stiffness` is pulled no harder than was asked for, and slack
    tissue less. Stiffer tissue is pulled harder, and nothing measures it. So the distances are
    only as safe as that number is true.

    Args:
        config: Source, stiffest tissue and largest tension.
    """

    def __init__(self, config: TensionConfig) -> None:
        self._config = config

    def furthest(self, grasp: Grasp, before: float, why: str) -> float:
        """Place on the pull's path that no pull may pass [m]; -inf: it begins nobody knows where.

        Where the pull was planned anew, its whole length counts from the grasp, too. Without a
        trusted tension a pull ends where the stiffest tissue has `maximum`. A tension whose gain is
        unchecked may read too little all along: it counts up to `limit` on that tissue.

        Args:
            grasp: With the path and the present place on it.
            before: How far the tissue was pulled where the path begins [m]; inf: nobody knows.
            why: The tension cannot be relied on, as `why` says it.
        """
        bound = self.distance(self._config.maximum) if why else self.bound
        return min(grasp.pull.length, bound) - before

    @property
    def bound(self) -> float:
        """Furthest that tissue may be pulled from the grasp by a tension [m]; inf: any way."""
        return inf if self._config.gain == "checked" else self.distance(self._config.limit)

    def distance(self, tension: float) -> float:
        """Distance [m] that gives a tension [N] on the stiffest tissue."""
        return tension / self._config.blind_stiffness

    def why(self, measured: Measurement) -> str:
        """Why the tension cannot be relied on, with tissue to be grasped or held; empty: it can.

        Torques give a tension only from the grasp on, where their bias is taken. So before it
        they count as trusted, and the pull checks again when it begins.
        """
        if self._config.source == "none":
            return "tension.source is none"
        if self._config.source == "joint_torque" and not measured.gripped:
            return ""
        return measured.tension_invalid_reason

    def words(self, why: str) -> str:
        """What the reply to a pull by distance adds."""
        stiffest = self._config.blind_stiffness
        return f" by distance, for tissue up to {stiffest:.0f} N/m (no trusted tension: {why})"


def unseen(why: str, config: TensionConfig) -> Rejected:
    """Refusal of a pull on tissue whose grasp nobody saw; `why` no tension is relied on."""
    words = "nobody saw where the tissue was grasped; release first"
    why = why or ("tension.gain is unchecked" if config.gain == "unchecked" else "")
    if why:
        words = f"no trusted tension ({why}), and {words}"
    return Rejected(Reason.DISPLACEMENT_LIMIT, words)


def plan(context: PlanningContext, is_more: bool) -> Accepted | Rejected:
    """Plan a step by distance, further along the pull or back."""
    config, measured, request = context.config.tension, context.measured, context.request
    by_distance, (grasp, seats) = DistanceForTension(config), held(context)
    why = by_distance.why(measured)
    step = request.distance or config.step_distance
    if why and not request.distance:
        step = by_distance.distance(request.tension or config.step_tension)
    target = grasp.s + step if is_more else grasp.s - step
    target = 0.0 if abs(target) <= ROUNDING else target
    before = pulled_before(grasp, context.situation.pulled)
    maximum = by_distance.furthest(grasp, before, why)
    if maximum == -inf and (is_more or target < 0.0):
        return unseen(why, config)
    if target < 0.0 or (is_more and target > maximum + ROUNDING):
        return too_far(target, maximum, before)
    if is_more:
        predicted = None if why else predicted_refusal(grasp, step, measured, config)
        refusal = predicted or present_refusal(measured, config)
        if refusal is not None:
            return refusal
    phase = context.along(PhaseKind.STEP, grasp.pull, context.config.speed.pull_speed)
    ceiling = config.maximum if is_more and not why else None
    phase = replace(phase, start=grasp.s, target=target, tension=ceiling)
    direction = "more" if is_more else "less"
    words = f"pulls {direction}: {grasp.s * 1e3:.1f} mm to {target * 1e3:.1f} mm"
    words += by_distance.words(why) if why else ""
    return context.accept(words, (*seats, phase), replace(grasp, s=target, tension=None))

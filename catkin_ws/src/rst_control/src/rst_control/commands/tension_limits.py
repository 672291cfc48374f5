# SPDX-License-Identifier: BSD-3-Clause
"""How hard and how far tissue may be pulled."""

from __future__ import annotations

from typing import Final

from rst_control.config import TensionConfig
from rst_control.planning.plan import Grasp
from rst_control.types import Measurement, Reason, Rejected

MIN_ROOM: Final = 5e-4  # [m] of pull path left, below which pulling further makes no sense
MIN_EASE: Final = 1e-5  # [m] of pull path to go back; stiff tissue is taut within 0.1 mm
ROUNDING: Final = 1e-9  # [m], [N] beyond a limit that sums of steps may be
AS_PLACED: Final = 1e-5  # [m] of pull beside the place on its path that is taken for none


def target_refusal(target: float, config: TensionConfig) -> Rejected | None:
    """Whether a tension [N] may not be asked for."""
    low, high = config.minimum, config.maximum
    if low - ROUNDING <= target <= high + ROUNDING:
        return None
    tension, least, most = _told_apart(target, low, high)
    words = f"tension would be {tension} N, allowed {least} to {most} N"
    return Rejected(Reason.TENSION_LIMIT, words)


def bounded(target: float, config: TensionConfig) -> float:
    """A tension that may be asked for [N], without the rounding by which it passes a limit."""
    return min(max(target, config.minimum), config.maximum)


def present_refusal(measured: Measurement, config: TensionConfig) -> Rejected | None:
    """Whether the measured tension forbids to pull more."""
    if measured.tension <= (allowed := config.limit):
        return None
    tension, most = _told_apart(measured.tension, allowed)
    return Rejected(Reason.TENSION_LIMIT, f"tension is {tension} N already, allowed {most} N")


def _told_apart(tension: float, *limits: float) -> list[str]:
    """A tension and its limits [N] with as many digits as make it differ from each of them."""
    digits = 2
    while digits < 9 and round(tension, digits) in [round(limit, digits) for limit in limits]:
        digits += 1
    return [f"{each:.{digits}f}" for each in (tension, *limits)]


def predicted_refusal(
    grasp: Grasp, step: float, measured: Measurement, config: TensionConfig
) -> Rejected | None:
    """Whether a step [m] would pull too hard, if the tissue goes on as it did so far."""
    slope = measured.tension / grasp.s if grasp.s > MIN_ROOM else 0.0
    predicted = measured.tension + slope * step
    return target_refusal(predicted, config) if predicted > config.maximum else None


def pulled_before(grasp: Grasp, pulled: float | None) -> float:
    """How far the tissue was pulled where the pull's path begins [m]; inf: nobody knows.

    Args:
        grasp: With the path and the present place on it.
        pulled: How far the tissue is pulled at that place [m]; None: as the grasp says.
    """
    before = 0.0 if pulled is None else pulled - grasp.s
    return before if before > AS_PLACED else 0.0


def room_refusal(grasp: Grasp, furthest: float, before: float) -> Rejected | None:
    """Whether the pull is at the furthest place [m] that it may go to."""
    if grasp.s + MIN_ROOM <= furthest:
        return None
    return too_far(grasp.s + MIN_ROOM, furthest, before)


def ease_refusal(grasp: Grasp, furthest: float, before: float) -> Rejected | None:
    """Whether the pull's path leads no further back, as where it was planned from here."""
    return too_far(grasp.s - MIN_ROOM, furthest, before) if grasp.s < MIN_EASE else None


def too_far(target: float, maximum: float, before: float = 0.0) -> Rejected:
    """Refusal of a pull to a place beyond the furthest one, or before its path begins.

    Args:
        target: That place on the path [m].
        maximum: The furthest place on the path [m].
        before: How far the tissue was pulled where the path begins [m]; the words count it in.
    """
    low = before if target < 0.0 else 0.0
    high = max(low, maximum + before)
    least = f"{low * 1e3:.1f}" if low else "0"
    words = f"pulled {(target + before) * 1e3:.1f} mm, allowed {least} to {high * 1e3:.1f} mm"
    return Rejected(Reason.DISPLACEMENT_LIMIT, words)

# SPDX-License-Identifier: BSD-3-Clause
"""How hard and how far tissue may be pulled."""

from __future__ import annotations

from typing import Final

from rst_control.config import TensionConfig
from rst_control.planning.plan import Grasp
from rst_control.types import Measurement, Reason, Rejected

MIN_ROOM: Final = 5e-4  # [m] of pull path left, below which pulling further makes no sense
MIN_EASE: Final = 1e-5  # [m] of pull path to go back; stiff tissue is taut within 0.1 mm
ROUNDING: Final = 1e-9  # [m] that a path may be shorter than asked for


def target_refusal(target: float, config: TensionConfig) -> Rejected | None:
    """Whether a tension [N] may not be asked for."""
    low, high = config.minimum, config.maximum
    if low <= target <= high:
        return None
    words = f"tension would be {target:.2f} N, allowed {low:.2f} to {high:.2f} N"
    return Rejected(Reason.TENSION_LIMIT, words)


def present_refusal(measured: Measurement, config: TensionConfig) -> Rejected | None:
    """Whether the measured tension forbids to pull more."""
    if measured.tension <= (allowed := config.limit):
        return None
    words = f"tension is {measured.tension:.2f} N already, allowed {allowed:.2f} N"
    return Rejected(Reason.TENSION_LIMIT, words)


def predicted_refusal(
    grasp: Grasp, step: float, measured: Measurement, config: TensionConfig
) -> Rejected | None:
    """Whether a step [m] would pull too hard, if the tissue goes on as it did so far."""
    slope = measured.tension / grasp.s if grasp.s > MIN_ROOM else 0.0
    predicted = measured.tension + slope * step
    return target_refusal(predicted, config) if predicted > config.maximum else None


def room_refusal(grasp: Grasp, furthest: float) -> Rejected | None:
    """Whether the pull is at the furthest place [m] that it may go to."""
    if grasp.s + MIN_ROOM <= furthest:
        return None
    return too_far(grasp.s + MIN_ROOM, furthest)


def ease_refusal(grasp: Grasp, furthest: float) -> Rejected | None:
    """Whether the pull's path leads no further back, as where it was planned from here."""
    return too_far(grasp.s - MIN_ROOM, furthest) if grasp.s < MIN_EASE else None


def too_far(target: float, maximum: float) -> Rejected:
    """Refusal of a pull to `target` [m] from the grasp, beyond `maximum` [m] or below 0."""
    words = f"pulled {target * 1e3:.1f} mm, allowed 0 to {max(0.0, maximum) * 1e3:.1f} mm"
    return Rejected(Reason.DISPLACEMENT_LIMIT, words)

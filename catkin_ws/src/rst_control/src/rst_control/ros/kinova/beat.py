# SPDX-License-Identifier: BSD-3-Clause
"""The beat of the bridge as a message, and back."""

from __future__ import annotations

import numpy as np

from rst_control.kinova.brake_plan import LastCourse
from rst_control.kinova.config import ARM_COUNT
from rst_control.msg import BridgeBeat
from rst_control.types import frozen_array

ROWS = ("position", "velocity", "sent", "goal", "speed", "bend")


def beat_message(last: LastCourse | None, now: float) -> BridgeBeat:
    """A beat at a time [s], with the course on which the arm is led; None: it is not."""
    if last is None:
        return BridgeBeat()
    message = BridgeBeat(is_leading=True, age=now - last.time)
    for row in ROWS:
        setattr(message, row, getattr(last, row).tolist())
    return message


def course_of(beat: BridgeBeat, now: float) -> LastCourse | None:
    """What a beat that came at a time [s] says of the course; None: the arm is not led.

    Numbers that are none say nothing: the arm is then stopped by the driver's own stop.
    """
    rows = {row: frozen_array(getattr(beat, row), ARM_COUNT) for row in ROWS}
    is_sound = np.isfinite([*rows.values()]).all() and np.isfinite(beat.age)
    return LastCourse(time=now - beat.age, **rows) if beat.is_leading and is_sound else None

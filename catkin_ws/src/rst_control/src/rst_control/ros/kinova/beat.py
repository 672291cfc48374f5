# SPDX-License-Identifier: BSD-3-Clause
"""The beat of the bridge as a message, and back."""

from __future__ import annotations

from itertools import chain

import numpy as np

from rst_control.kinova.brake_plan import LastCourse
from rst_control.msg import BridgeBeat
from rst_control.types import ARM_COUNT, frozen_array

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
    rows = {row: getattr(beat, row) for row in ROWS}
    if not beat.is_leading or not np.isfinite([beat.age, *chain(*rows.values())]).all():
        return None
    frozen = {row: frozen_array(values, ARM_COUNT) for row, values in rows.items()}
    return LastCourse(time=now - beat.age, **frozen)

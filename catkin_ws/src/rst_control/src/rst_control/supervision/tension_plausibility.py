# SPDX-License-Identifier: BSD-3-Clause
"""Whether the tension measured while tissue is pulled can be true.

`grasp_response.py` asks whether it rises as the tissue's stiffness lets expect. This asks whether
the sensor measures at all. Tension is the length of a force, so a wrong sign changes nothing.
"""

from __future__ import annotations

import numpy as np

from rst_control.config.sensors import SensorConfig
from rst_control.tension.grasp_response import LOADED
from rst_control.types import Measurement


class TensionPlausibility:
    """Looks at the tension from measurement to measurement.

    Args:
        config: What a working sensor never says.
        after: How long it stays the same before it counts as stuck [s].
    """

    def __init__(self, config: SensorConfig, after: float) -> None:
        self._config, self._after = config, after
        self._changed: tuple[float, float] | None = None  # place [m], time [s] of the last change

    def forget(self) -> None:
        """Begin anew."""
        self._changed = None

    def update(self, last: Measurement, measured: Measurement, pulled: float | None) -> str:
        """What cannot be true; empty: nothing.

        Args:
            last: The measurement before.
            measured: The newest.
            pulled: Place on the pull's path while it raises the tension [m]; None: it does not.
        """
        if pulled is None or not (last.gripped and measured.gripped):
            self._changed = None
            return ""
        return (
            self._jump(last, measured)
            or self._dead(measured, pulled)
            or self._stuck(last, measured, pulled)
        )

    def _jump(self, last: Measurement, measured: Measurement) -> str:
        change, allowed = measured.tension - last.tension, self._config.tension_jump
        if abs(change) <= allowed:
            return ""
        return (
            f"tension jumped by {change:+.2f} N to {measured.tension:.2f} N, allowed "
            f"{allowed:.2f}: sensor faulty, or tissue torn"
        )

    def _dead(self, measured: Measurement, pulled: float) -> str:
        allowed = self._config.slack_way
        if pulled <= allowed or measured.tension >= LOADED:
            return ""
        return (
            f"tension {measured.tension:.3f} N after {pulled * 1e3:.1f} mm of pull, at least "
            f"{LOADED:.2f} N expected after {allowed * 1e3:.1f} mm: tissue slack, or "
            "sensor dead"
        )

    def _stuck(self, last: Measurement, measured: Measurement, pulled: float) -> str:
        is_same = np.array_equal(last.force, measured.force)
        if not is_same or measured.tension < LOADED or self._changed is None:
            self._changed = pulled, measured.stamp
            return ""
        way, time = pulled - self._changed[0], measured.stamp - self._changed[1]
        if way <= self._config.tension_frozen_way or time < self._after:
            return ""
        return (
            f"tension stuck: it reads {measured.tension:.4f} N without any change over "
            f"{way * 1e3:.2f} mm of pull, allowed {self._config.tension_frozen_way * 1e3:.2f} mm"
        )

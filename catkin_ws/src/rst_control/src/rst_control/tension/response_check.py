# SPDX-License-Identifier: BSD-3-Clause
"""Whether tension rises as tissue is pulled; where it does not, tissue tore or a sensor is dead."""

from __future__ import annotations

from rst_control.types import Cause, Reason

EXPECTED = 0.15  # [N] of rise after which it is looked whether it came
MIN_SHARE = 0.25  # of the rise expected that must have come
MIN_TENSION = 0.05  # [N] and
MIN_WAY = 2e-4  # [m] of pull from the grasp, below which nothing is expected


class ResponseCheck:
    """Compares the rise of the tension with what the pull so far lets expect.

    Tissue stiffens as it is pulled. So each further way should add at least the tension that the
    mean stiffness since the grasp gives; a quarter of that is asked for.
    """

    def __init__(self) -> None:
        self._s = self._tension = 0.0  # where it was looked last
        self.objection: Cause | None = None  # None: the tension follows the pull

    def update(self, s: float, tension: float) -> None:
        """Take in the pull from the grasp [m] and its tension [N]."""
        if s <= self._s or self._s < MIN_WAY or self._tension < MIN_TENSION:
            self._s, self._tension = s, tension
            return
        expected = self._tension / self._s * (s - self._s)
        if expected < EXPECTED:
            return
        rise = tension - self._tension
        if rise < MIN_SHARE * expected:
            words = (
                f"tension rose by {rise:.2f} N over {(s - self._s) * 1e3:.1f} mm of pull, at least "
                f"{MIN_SHARE * expected:.2f} N expected: tissue torn or slipping, or sensor dead"
            )
            self.objection = Cause(Reason.NO_RESPONSE_TO_PULL, words)
        self._s, self._tension = s, tension

# SPDX-License-Identifier: BSD-3-Clause
"""When closing jaws take hold of tissue, and when opening jaws let it go."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rst_control.backends.tissue import Tissue


class Jaws:
    """Watches the opening of the jaws; tissue is taken only by jaws that were open before.

    Args:
        tissue: What may be taken.
        closed_opening: Closed below this [rad].
        held_opening: Open beyond this [rad].
    """

    def __init__(self, tissue: Tissue, closed_opening: float, held_opening: float) -> None:
        self._tissue = tissue
        self._closed, self._open = closed_opening, held_opening
        self._were_open = False

    def follow(self, opening: float, tip: NDArray[np.float64]) -> None:
        """Take or let go of the tissue as the jaws now stand.

        Args:
            opening: Angle between the jaws [rad].
            tip: Point between their tips, base frame, [m]. Shape (3,).
        """
        if opening > self._open:
            self._were_open = True
            self._tissue.release()
        elif opening < self._closed and self._were_open:
            self._were_open = False
            self._tissue.grasp(tip)

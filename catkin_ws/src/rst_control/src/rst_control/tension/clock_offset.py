# SPDX-License-Identifier: BSD-3-Clause
"""When a reading was taken, on the receiver's clock.

Messages come late and in bunches, so the time between two arrivals says little about the time
between two readings; what is computed from it, such as an acceleration, would be far off. The
sender's stamps say it, but by a clock that may be set at any moment.
"""

from __future__ import annotations


class SentTimes:
    """Translates the sender's stamps to the receiver's steady clock.

    Args:
        most: By how much arrivals may be late or bunched [s]. Beyond, or where stamps go back, the
            sender's clock was set, and the translation begins anew with that arrival.
    """

    def __init__(self, most: float) -> None:
        self._most = most
        self._offset: float | None = None
        self._last = 0.0  # [s] stamp

    def of(self, sent: float, arrived: float) -> float:
        """Time of a reading [s], receiver's clock, as far from the last as the stamps say.

        Args:
            sent: Stamp of the sender [s].
            arrived: On the receiver's clock [s].
        """
        is_back, self._last = sent < self._last, sent
        if self._offset is None or is_back or abs(sent + self._offset - arrived) > self._most:
            self._offset = arrived - sent
        return sent + self._offset

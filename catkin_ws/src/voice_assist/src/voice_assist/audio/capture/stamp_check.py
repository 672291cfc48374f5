# SPDX-License-Identifier: BSD-3-Clause
"""Compares the stamps of sound from another host with this host's clock.

Stamps that are ahead hide how late recognition is, and let the robot's own voice count. With stamps
that are late, every early decision is skipped, so a "stop" is heard later.
"""

from __future__ import annotations

from typing import Final

MAX_AHEAD: Final = 0.2  # [s]; a publisher that stamps the end of its sound is ahead by one message
MAX_LATE: Final = 0.3  # [s]; early.max_backlog less the time of one pass
JUDGED_AFTER: Final = 1.0  # [s] of sound whose least lateness is judged at once


class StampCheck:
    """Follows the stamps of one source by their least lateness in each second.

    No delay makes sound early, so that one shows the clocks. One late message does not change it.
    """

    def __init__(self) -> None:
        self._since: float | None = None  # [s] clock time from when on is judged
        self._least = float("inf")  # [s] lateness since
        self._words = ""

    def __call__(self, end: float, now: float) -> str:
        """What is wrong, in words that stay the same until it is over; empty: nothing.

        Args:
            end: Stamp of the end of a block of sound [s].
            now: Clock time at which it came [s].
        """
        late = now - end
        since = now if self._since is None else self._since
        self._least = min(self._least, late)
        if 0.0 <= now - since < JUDGED_AFTER:
            self._since = since
            return self._words
        found = _explained(self._least)
        self._words = (self._words or found) if found else ""
        # this one counts in the next second, too: no second is judged by one message alone
        self._since, self._least = now, late
        return self._words


def _explained(late: float) -> str:
    if late < -MAX_AHEAD:
        ahead = f"the clock of the sound's host is {-late:.2f} s ahead"
        return f"{ahead}, allowed {MAX_AHEAD:g} s: run chrony"
    if late > MAX_LATE:
        behind = f"the sound comes {late:.2f} s late, or the clock of its host is behind"
        return f"{behind}, allowed {MAX_LATE:g} s: run chrony, check the network"
    return ""

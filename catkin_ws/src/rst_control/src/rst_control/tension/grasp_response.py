# SPDX-License-Identifier: BSD-3-Clause
"""Whether the tension answers the pull as tissue must, from the grasp to the release.

Three bounds hold over all commands in between:

- Tissue that was pulled further pulls harder. A reading that falls short of the line through
  earlier readings is not believed any more (torn, slipping, stuck, drifting, dead).
- Until a reading at rest has shown that the sensor works, the pull goes no further than lets
  the stiffest tissue of the settings reach the limit. That holds for a late or dead sensor too.
- What the tension loses while nothing moves adds up. Beyond what tissue relaxes by, the sensor
  drifts, or the tissue slips.

A sensor whose readings are all too small by the same factor looks like softer tissue. Only
distance bounds the pull then: `tension.gain: unchecked`, or `scene.max_displacement`.
"""

from __future__ import annotations

from collections import deque
from math import inf, sqrt
from typing import Final

from rst_control.config import TensionConfig
from rst_control.tension.falls_at_rest import FallsAtRest
from rst_control.types import Cause, Reason

LOADED: Final = 0.05  # [N] below which tissue counts as slack
SHARE: Final = 0.8  # of an earlier stiffness that tissue keeps at least
MIN_RISE: Final = 0.2  # [N] over which a stiffness is found, or
MIN_RISE_NOISE: Final = 6.0  # times the noise, where that is more
SPACING: Final = 0.1  # [N] between two readings that are remembered
RECENT: Final = 0.02  # [s] at least, over which the lowest reading counts
LATE: Final = 2.0  # times the delay, by which a reading is late at most
LISTEN: Final = 0.1  # [s] at rest, at least, in which a reading must stay
MIN_CONFIRMED: Final = 0.1  # [N] of rise that shows a sensor at work
WELL_CONFIRMED: Final = 0.3  # [N] from which the line through earlier readings is bound enough
LATE_SHARE: Final = 0.3  # of its rise in motion that a reading may still go on to rise by
SAME: Final = 1e-7  # [m] of pull that counts as none, over a whole rest
WINDOW: Final = 3.0  # standard deviations that a mean may be off


class GraspResponse:
    """Judges each reading while tissue is held.

    Args:
        config: Limit, stiffest tissue, delay and noise of the tension.
        deficit: That a reading may fall short of the line through earlier ones [N].
    """

    def __init__(self, config: TensionConfig, deficit: float) -> None:
        self._config, self._deficit = config, deficit
        self._min_rise = max(MIN_RISE, MIN_RISE_NOISE * config.noise)
        self._listen = max(LISTEN, LATE * config.delay)
        self._falls = FallsAtRest()
        self.grasp()

    def grasp(self) -> None:
        """Begin anew, with tissue that was just grasped."""
        self.objection: Cause | None = None  # why the tension is not believed until the release
        self._first: float | None = None  # [N] at the grasp
        self._past: deque[tuple[float, float]] = deque()  # times and pulls, as far back as matters
        self._recent: deque[tuple[float, float]] = deque()  # times and tensions
        self._onset = 0.0, 0.0  # pull [m] and tension [N] from which on it rose
        self._points: list[tuple[float, float]] = []  # the same of later readings
        self._lines: list[tuple[float, float, float]] = []  # pull [m], tension [N], slope [N/m]
        self._confirmed = 0.0, 0.0  # pull [m] and tension [N] of the last reading at rest
        self._moved_for = 0.0  # [s] since then
        self._rest: list[tuple[float, float]] = []  # times and tensions at rest
        self._rests_since, self._rests_at = inf, 0.0  # time [s] and pull [m] where it began
        self._is_free = False
        self._falls.forget()

    @property
    def room(self) -> float:
        """How much further the pull may go before its tension is confirmed at rest [m]."""
        if self._is_free or not self._past:
            return inf
        pull, tension = self._confirmed
        allowed = (self._config.limit - tension) / self._config.blind_stiffness
        return pull + max(0.0, allowed) - self._past[-1][1]

    def update(self, stamp: float, pull: float, tension: float) -> None:
        """Take in a reading.

        Args:
            stamp: When it came [s].
            pull: How far the tissue is pulled from where it was grasped [m].
            tension: The reading [N].
        """
        if self._past and stamp <= self._past[-1][0]:
            return
        if self._first is None:
            self._first = tension
            self._onset = self._confirmed = pull, tension
            self._rests_at = pull
        self._follow_rest(stamp, pull, tension)
        self._keep(stamp, pull, tension)
        if self.objection is None:
            self._compare(self._places(stamp)[0], tension)
            self._remember()
            self._confirm(pull)

    def _keep(self, stamp: float, pull: float, tension: float) -> None:
        past, recent, delay = self._past, self._recent, self._config.delay
        window = max(RECENT, delay)
        past.append((stamp, pull))
        while len(past) > 1 and past[1][0] <= stamp - window - LATE * delay:
            past.popleft()
        recent.append((stamp, tension))
        while recent[0][0] < stamp - window:
            recent.popleft()

    def _places(self, stamp: float) -> tuple[float, float]:
        """Least and furthest pull [m] at which a reading of a time [s] may have arisen."""
        first = stamp - LATE * self._config.delay
        pulls = [pull for time, pull in self._past if first <= time <= stamp]
        return min(pulls), max(pulls)

    def _compare(self, pull: float, tension: float) -> None:
        """Object to a reading below the line through earlier ones."""
        lines = (t + SHARE * slope * (pull - p) for p, t, slope in self._lines if pull >= p - SAME)
        expected = max(lines, default=0.0)
        if expected - tension <= self._deficit:
            return
        self._object(
            f"tension {tension:.2f} N at {pull * 1e3:.1f} mm of pull, at least "
            f"{expected - self._deficit:.2f} N expected"
        )

    def _remember(self) -> None:
        """Note where the tension rose to, as its lowest recent reading has it.

        Where it arose is known but for the delay. So the stiffness is taken as the least that
        the two readings allow.
        """
        tension, stamp = min((t, time) for time, t in self._recent)
        highest = self._points[-1][1] if self._points else -inf
        if self._points and tension < highest + SPACING:
            return
        least, furthest = self._places(stamp)
        if not self._points and tension <= LOADED:
            self._onset = least, tension
            return
        slopes = [
            (tension - lower) / (furthest - pull)
            for pull, lower in (self._onset, *self._points)
            if lower <= tension - self._min_rise and pull < furthest - SAME
        ]
        if slopes:
            self._lines.append((furthest, tension, max(slopes)))
        self._points.append((least, tension))

    def _follow_rest(self, stamp: float, pull: float, tension: float) -> None:
        """Collect the readings of a rest, but for the first, which are late.

        A rest has one place: what creeps is in motion, however little it does from one reading to
        the next.
        """
        if abs(pull - self._rests_at) > SAME:
            self._moved_for += stamp - self._past[-1][0]
            self._rests_since, self._rests_at, self._rest = inf, pull, []
            self._falls.move()
            return
        self._rests_since = min(self._rests_since, stamp)
        if stamp - self._rests_since >= LATE * self._config.delay + RECENT:
            self._rest.append((stamp, tension))

    def _confirm(self, pull: float) -> None:
        """Judge a rest that was long enough."""
        rest = self._rest
        if len(rest) < 4 or rest[-1][0] - rest[0][0] < self._listen:
            return
        half = len(rest) // 2
        before, after = (sum(t for _, t in r) / len(r) for r in (rest[:half], rest[half:]))
        span = rest[-1][0] - rest[0][0]
        self._rest = []
        (_, tension), rise = self._confirmed, after - self._confirmed[1]
        error = WINDOW * self._config.noise * sqrt(4.0 / len(rest))
        going_on = (after - before - error) / (0.5 * span) * self._moved_for
        times = rest[0][0] + 0.25 * span, rest[-1][0] - 0.25 * span
        self._falls.update((times[0], before), (times[1], after), error)
        is_confirmed = rise >= MIN_CONFIRMED
        if is_confirmed and going_on > LATE_SHARE * rise:
            self._object(
                f"tension rose from {before:.2f} to {after:.2f} N within {span:.2f} s at rest"
            )
        elif self._falls.total > self._deficit:
            self._object(
                f"tension fell by {self._falls.total:.2f} N in all while nothing moved, "
                f"allowed {self._deficit:.2f} N"
            )
        elif is_confirmed:
            self._confirmed, self._moved_for = (pull, after), 0.0
            self._is_free = after - (self._first or 0.0) >= WELL_CONFIRMED and bool(self._lines)
        elif self.room <= SAME:
            self._object(
                f"tension {after:.2f} N after {pull * 1e3:.1f} mm of pull, at least "
                f"{tension + MIN_CONFIRMED:.2f} N expected"
            )

    def _object(self, words: str) -> None:
        words = f"{words}: tissue torn or slipping, or sensor dead, late or drifting"
        self.objection = Cause(Reason.NO_RESPONSE_TO_PULL, words)

# SPDX-License-Identifier: BSD-3-Clause
"""What the loss of a part came to, from what moved: pure, so that it can be shown to fail."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.common.resumable import measured
from support.figures import Figure, percentiles

Array = NDArray[np.float64]
STILL = 2e-5  # [rad] from where a joint ends; nearer than this it counts as there
SETTLED = 0.1  # [s] at the end of a watch without motion, without which nothing counts as at rest
MOVING = 1e-3  # [rad/s] of the fastest joint, above which a loss came in motion
GAP = 0.06  # [s] without a sample over which nobody knows what moved
BUSY = 4.0  # processes that wanted the cores, above which other work went on; its own are two
DEMANDED = 0.1  # [s] from a loss, or from a stop, to the last movement


@dataclass(frozen=True)
class JointTrace:
    """What was seen of joints, or of set-points, in order."""

    times: Array  # (n,), [s] of time.monotonic(), as the sender stamped them
    positions: Array  # (n, k), [rad]

    def between(self, since: float, until: float) -> JointTrace:
        """The part from the last sample up to `since` to the last one up to `until` [s]."""
        first = max(0, int(np.searchsorted(self.times, since, side="right")) - 1)
        last = int(np.searchsorted(self.times, until, side="right"))
        return JointTrace(self.times[first:last], self.positions[first:last])


@dataclass(frozen=True)
class LossRule:
    """What the documentation says of the loss of a part."""

    words: str
    limit: float  # [s] to rest by itself
    spares: tuple[str, ...] = ()  # motions that go on instead; a stop must then work
    finishes: float = 0.0  # [s] after SIGCONT in which a frozen part may finish its braking
    may_end: bool = False  # what is watched may fall silent
    demanded: float = DEMANDED  # [s] that is aimed at, whatever is documented

    def limit_of(self, motion: str) -> float | None:
        """Time to rest by itself [s]; None: the motion goes on."""
        return None if motion.split(",")[0] in self.spares else self.limit


@dataclass(frozen=True)
class PartLoss:
    """One part lost in one motion, and all that followed."""

    victim: str
    way: str  # SIGKILL, SIGSTOP, hang or crash
    motion: str  # what was moving
    speed: float  # [rad/s] of the fastest joint when it was lost
    joint: str  # that moved last, after the loss or the stop; empty: none moved
    alone: float  # [s] from the loss to the last movement without any stop; inf: it went on
    arm: float  # [s] the same of all joints but the jaws
    stopped: float | None  # [s] from a stop given then to the last movement; None: none was given
    by: str  # by which way that stop was given
    drift: float  # [rad] largest way of a joint from rest to the next "hey robot"
    back: float | None  # [s] from the return of the part to the next motion; None: never
    found: bool  # new clients found the controller afterwards
    objections: tuple[str, ...]  # what else was not as it must be
    load: float  # average number of processes that wanted the machine's cores in that minute
    finished: bool = False  # the motion came to its own end as the part was lost

    @staticmethod
    def from_json(row: dict[str, Any]) -> PartLoss:
        """Of a row that was kept."""
        return PartLoss(**{**row, "objections": tuple(row["objections"])})

    @property
    def aside(self) -> str:
        """Why it says nothing of this loss, whatever came of it; empty: it counts."""
        if self.load > BUSY:
            return "other work on the machine"
        return "motion at its end" if self.finished else ""


def ways_of(victim: str) -> tuple[str, str]:
    """How a part is lost."""
    return ("hang", "crash") if victim == "recogniser" else ("SIGKILL", "SIGSTOP")


def left(victim: str, losses: Sequence[PartLoss], wanted: Mapping[str, int]) -> list[str]:
    """Ways that are still to be taken, once for each time, those most wanting first.

    Args:
        victim: One of the parts.
        losses: Of it, so far.
        wanted: Losses by each of its ways.
    """
    ways = ways_of(victim)
    counted = [loss.way for loss in losses if not loss.aside]
    missing = {way: wanted[way] - counted.count(way) for way in ways}
    order = sorted(ways, key=lambda way: -missing[way])
    return [way for way in order for _ in range(missing[way])]


def last_movement(trace: JointTrace, since: float, until: float) -> float:
    """Time from a moment to the last movement [s]; 0: none; infinity: it did not end.

    Args:
        trace: Of what is judged.
        since: The moment [s].
        until: End of the watch [s].
    """
    seen = trace.between(since, until)
    if len(seen.times) < 2:
        return 0.0
    away = np.abs(seen.positions - seen.positions[-1]).max(axis=1) > STILL
    if not away.any():
        return 0.0
    rest = float(seen.times[int(np.flatnonzero(away)[-1]) + 1])
    return float("inf") if rest > until - SETTLED else max(0.0, rest - since)


def last_joint(trace: JointTrace, since: float, until: float) -> int | None:
    """Index of the joint that moved last; None: none moved."""
    seen = trace.between(since, until)
    if len(seen.times) < 2:
        return None
    away = np.abs(seen.positions - seen.positions[-1]) > STILL
    if not away.any():
        return None
    return int(away[int(np.flatnonzero(away.any(axis=1))[-1])].argmax())


def drift(trace: JointTrace, since: float, until: float) -> float:
    """Largest way of any joint from where it was at `since` [rad]; 0 where nothing was seen."""
    seen = trace.between(since, until)
    if len(seen.times) < 2:
        return 0.0
    return float(np.abs(seen.positions - seen.positions[0]).max())


def speed(trace: JointTrace, moment: float, span: float = 0.05) -> float:
    """Of the fastest joint over the time before a moment [rad/s]; 0 where nothing was seen."""
    seen = trace.between(moment - span, moment)
    if len(seen.times) < 2:
        return 0.0
    way = np.abs(seen.positions[-1] - seen.positions[0]).max()
    return float(way / (seen.times[-1] - seen.times[0]))


def blindness(trace: JointTrace, since: float, until: float) -> str:
    """Why nothing can be said of a stretch of time; empty: it was seen whole."""
    times = trace.between(since, until).times
    edges = np.concatenate([[since], times[times > since], [until]])
    longest = float(np.diff(edges).max())
    return f"nothing was seen for {longest * 1e3:.0f} ms" if longest > GAP else ""


def objections(loss: PartLoss, rule: LossRule) -> list[str]:
    """What of a loss is not as documented; empty: all is."""
    found = list(loss.objections)
    limit = rule.limit_of(loss.motion)
    if limit is not None and loss.alone > limit:
        found.append(f"moved for {loss.alone * 1e3:.0f} ms, documented {limit * 1e3:.0f} ms")
    if loss.stopped is not None and loss.stopped > DEMANDED:
        found.append(f"moved for {loss.stopped * 1e3:.0f} ms after a stop by {loss.by}")
    if limit is None and loss.stopped is None and not np.isfinite(loss.alone):
        found.append("moved on, and no stop was tried")
    if loss.drift > STILL:
        found.append(f'moved by {loss.drift * 1e3:.3f} mrad without "hey robot"')
    if loss.back is None:
        found.append("the next command did not move it")
    return found


def figures(losses: Sequence[PartLoss], rules: dict[str, LossRule], planned: int) -> list[Figure]:
    """Figures beside their targets, victim by victim.

    Args:
        losses: All.
        rules: Of each victim.
        planned: How many there were to be.
    """
    reasons = [loss.aside for loss in losses if loss.aside]
    losses = [loss for loss in losses if not loss.aside]
    found = [measured(len(losses), "losses", planned)]
    for victim, rule in rules.items():
        for way in sorted({loss.way for loss in losses if loss.victim == victim}):
            some = [loss for loss in losses if (loss.victim, loss.way) == (victim, way)]
            found += _of_one(f"{victim}, {way}", some, rule)
    judged = [loss for loss in losses if rules[loss.victim].limit_of(loss.motion) is not None]
    for what, name in (("arm", "arm"), ("arm and jaws", "alone")):
        rest = sum(getattr(loss, name) <= rules[loss.victim].demanded for loss in judged)
        words = f"{what} at rest in time by the loss alone"
        found.append(Figure(words, rest, "", len(judged), at_most=False))
    for reason in sorted(set(reasons)):
        note = "(by that alone, before anything was judged)"
        found.append(
            Figure(f"set aside and repeated, {reason}", reasons.count(reason), "", note=note)
        )
    if losses:
        loads = [loss.load for loss in losses]
        found.append(Figure("load average, median", float(np.median(loads)), ""))
        found.append(Figure("load average, max", max(loads), ""))
    return found


def _of_one(name: str, losses: Sequence[PartLoss], rule: LossRule) -> list[Figure]:
    judged = [(loss, objections(loss, rule)) for loss in losses]
    wrong = [(loss, objected) for loss, objected in judged if objected]
    note = ""
    if wrong:
        first, words = wrong[0]
        note = f"(the first, {first.motion}, {first.joint} last: {'; '.join(words)})"
    judged_only = [loss for loss in losses if rule.limit_of(loss.motion) is not None]
    went_on = sum(not np.isfinite(loss.alone) for loss in judged_only)
    ended = [loss.alone * 1e3 for loss in judged_only if np.isfinite(loss.alone)]
    arm = [loss.arm * 1e3 for loss in judged_only if np.isfinite(loss.arm)]
    stopped = [loss.stopped * 1e3 for loss in losses if loss.stopped is not None]
    back = [loss.back for loss in losses if loss.back is not None]
    moving = sum(loss.speed > MOVING for loss in losses)
    found = [
        Figure(f"{name}: in motion when lost", moving, "", len(losses), at_most=False),
        Figure(f"{name}: not as documented", len(wrong), "", 0.0, note=note),
        Figure(f"{name}: moved on by itself", went_on, "", 0.0, note=f"({rule.words})"),
    ]
    if ended:
        what = f"{name}: loss to last movement"
        found += percentiles(what, ended, "ms", {100: rule.demanded * 1e3})
    if arm:
        what = f"{name}: loss to last movement of the arm"
        found += percentiles(what, arm, "ms", {100: rule.demanded * 1e3})
    if stopped:
        what = f"{name}: a stop given meanwhile to last movement"
        found += percentiles(what, stopped, "ms", {100: DEMANDED * 1e3})
    furthest = max(loss.drift for loss in losses) * 1e6
    found.append(Figure(f'{name}: way before "hey robot", max', furthest, "urad", STILL * 1e6))
    if back:
        found.append(Figure(f"{name}: return of the part to motion, max", max(back), "s"))
    lost = sum(not loss.found for loss in losses)
    return [*found, Figure(f"{name}: new clients do not find the controller", lost, "", 0.0)]

# SPDX-License-Identifier: BSD-3-Clause
"""What a bad network came to, from set-points and joint states: traces in, verdicts out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bench.safety.stops.judge import DRIFT, STILL, SetpointCourse
from rst_control.types import Reason
from support.figures import Figure

Array = NDArray[np.float64]
ALLOWED = 0.2  # [s] for set-points to rest
MEASURED_STILL = 0.01  # [rad/s] as watchdogs.at_rest_speed of controller.yaml
WATCHED = 0.3  # [s] after the time allowed, at least
BY_THE_NETWORK = frozenset(  # reasons of a halt that a bad network or a "stop" gives
    reason.value
    for reason in (
        *(Reason.VOICE_SILENT, Reason.NODE_LOST),
        *(Reason.STOP_TOPIC, Reason.STOP_COMMAND, Reason.STOP_CANCEL),
    )
)
RECOVERS = 10.0  # [s] from a good network to the next motion
# [s] after a command was said at which it may begin no more: the answer's 1 s, and some
TOO_LATE = 1.2


@dataclass(frozen=True, eq=False)
class NetworkTrial:
    """One fault of the network, and all that was seen of the robot until it was armed again."""

    fault: str
    moment: float  # [s] from which the time allowed counts
    since: str  # what happened then: "fault" or "stop said"; "command said": nothing may set off
    setpoints: SetpointCourse  # from before the moment until just before "hey robot"
    measured: SetpointCourse
    halted: bool  # just before "hey robot"
    reason: str  # code of why it was halted, as in ReasonCode.msg
    rearmed: float | None  # [s] from the good network to "hey robot" accepted; None: it never was
    moved: float | None  # [s] from the good network to the next command in motion; None: never


@dataclass(frozen=True)
class NetworkVerdict:
    """What a trial came to."""

    fault: str
    held: float | None  # [s] until arm and tool rest by their set-points; None: they rested before
    jaws: float | None  # [s] until the jaws rest by theirs
    measured: float | None  # [s] until all joints rest, measured
    objections: tuple[str, ...]  # empty: as it should be


def tool_speeds(course: SetpointCourse) -> Array:
    """Norm of the velocities of arm and wrist, yaw for both fingers [rad/s]. Shape (n,)."""
    v = course.velocities
    yaw = 0.5 * (v[:, 8] - v[:, 9])  # both fingers count positive when they open
    speeds: Array = np.linalg.norm(np.column_stack([v[:, :8], yaw]), axis=1)
    return speeds


def jaw_speeds(course: SetpointCourse) -> Array:
    """Speed at which the jaws open or close [rad/s]. Shape (n,)."""
    speeds: Array = np.abs(course.velocities[:, 8] + course.velocities[:, 9])
    return speeds


def rest(stamps: Array, speeds: Array, moment: float, still: float) -> float | None:
    """Time from a moment until it rests for good [s].

    Args:
        stamps: Of the samples [s]. Shape (n,).
        speeds: Of the samples [rad/s]. Shape (n,).
        moment: From which it counts [s].
        still: Speed up to which it rests [rad/s].

    Returns:
        None where it rested from the moment on; infinity where it never came to rest.
    """
    moving = np.nonzero((stamps > moment) & (speeds > still))[0]
    if not len(moving):
        return None
    ended = int(moving[-1]) + 1
    return float(stamps[ended] - moment) if ended < len(stamps) else float("inf")


def judge(trial: NetworkTrial) -> NetworkVerdict:
    """What a trial came to."""
    course, moment = trial.setpoints, trial.moment
    held = rest(course.stamps, tool_speeds(course), moment, STILL)
    jaws = rest(course.stamps, jaw_speeds(course), moment, STILL)
    shown = trial.measured
    speeds = np.linalg.norm(shown.velocities, axis=1)
    measured = rest(shown.stamps, speeds, moment, MEASURED_STILL)
    if trial.since == "command said":
        objections = [*_late(course, moment), *_recovery(trial)]
        return NetworkVerdict(trial.fault, None, None, None, tuple(objections))
    objections = [*_hold(trial, held), *_afterwards(trial, held, jaws), *_recovery(trial)]
    return NetworkVerdict(trial.fault, held, jaws, measured, tuple(objections))


def _hold(trial: NetworkTrial, held: float | None) -> list[str]:
    found = []
    if held is not None and held > ALLOWED:
        found.append(f"moved for {held * 1e3:.0f} ms, allowed {ALLOWED * 1e3:.0f} ms")
    if not trial.halted:
        found.append("not halted")
    elif trial.reason not in BY_THE_NETWORK:
        found.append(f"halted for another reason: {trial.reason}")
    return found


def _afterwards(trial: NetworkTrial, held: float | None, jaws: float | None) -> list[str]:
    """Objections to what came after it rested, until "hey robot"."""
    course = trial.setpoints
    begin = trial.moment + max(ALLOWED, held or 0.0, jaws or 0.0)
    if not np.isfinite(begin):
        return []
    still = course.positions[course.stamps > begin]
    watched = trial.measured.stamps[-1] - begin if len(trial.measured.stamps) else 0.0
    if len(still) < 2 or watched < WATCHED:
        return ["not watched long enough after it"]
    moved = float(np.abs(np.diff(still, axis=0)).max())
    return [f"moved again, by {moved:.2g} rad at once"] if moved > DRIFT else []


def _late(course: SetpointCourse, said: float) -> list[str]:
    """Objection to a motion that a command set off too late after it was said at a time [s]."""
    moving = np.linalg.norm(course.velocities, axis=1) > STILL
    begun = np.nonzero(moving[1:] & ~moving[:-1])[0] + 1
    late = [float(t - said) for t in course.stamps[begun] if t > said + TOO_LATE]
    return [f"set off {late[0]:.1f} s after it was said"] if late else []


def _recovery(trial: NetworkTrial) -> list[str]:
    if trial.rearmed is None:
        return ['"hey robot" was never accepted again']
    if trial.moved is None:
        return ["no command was carried out any more"]
    if trial.moved > RECOVERS:
        return [f"back after {trial.moved:.1f} s, allowed {RECOVERS:.0f} s"]
    return []


def figures(trials: Sequence[NetworkTrial], void: int, note: str) -> list[Figure]:
    """Figures of all trials, fault by fault.

    Args:
        trials: That count.
        void: Trials that had to be made anew, since something else stopped the robot before.
        note: On the system that was measured.
    """
    found: list[Figure] = []
    for fault in dict.fromkeys(trial.fault for trial in trials):
        those = [trial for trial in trials if trial.fault == fault]
        found += _of_one(f"two hosts, {fault}", those, [judge(trial) for trial in those])
    return [*found, Figure("two hosts: trials made anew", void, "", note=note)]


def _of_one(
    name: str, trials: Sequence[NetworkTrial], verdicts: Sequence[NetworkVerdict]
) -> list[Figure]:
    bad = [verdict for verdict in verdicts if verdict.objections]
    first = f"(the first: {'; '.join(bad[0].objections)})" if bad else ""
    count = Figure(f"{name}: trials", len(trials), "", note=f"(counted from: {trials[0].since})")
    found = [count, Figure(f"{name}: not as it should be", len(bad), "", 0.0, note=first)]
    for what, values, target in (
        ("to rest, set-points", [v.held for v in verdicts], ALLOWED * 1e3),
        ("to rest, jaws", [v.jaws for v in verdicts], None),
        ("to rest, measured", [v.measured for v in verdicts], None),
    ):
        times = [value * 1e3 for value in values if value is not None]
        if times:
            p50 = f"(of {len(times)} in motion; p50 {np.median(times):.0f} ms)"
            found.append(Figure(f"{name}: {what}, max", max(times), "ms", target, note=p50))
    back = [trial.moved for trial in trials if trial.moved is not None]
    if back:
        what = f"{name}: good network to the next motion, max"
        found.append(Figure(what, max(back), "s", RECOVERS, note=f"(of {len(back)})"))
    return found

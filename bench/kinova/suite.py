# SPDX-License-Identifier: BSD-3-Clause
"""The controller on the drivers' strict simulation, led by velocities, beside the fast simulation.

All seven commands, stops at random moments of the way to the tissue, and what the arm does where
controller, bridge or feedback are lost in motion. All in one process and in lock-step: what ROS
itself takes is not in it. Errors of the trocar, ways and tension are those of the true joints.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass

import numpy as np

from bench.common.rig import Rig
from bench.kinova.rig import KinovaRig, Loss, kinova_motion
from rst_control.config import load_motion_config, load_simulation_config
from rst_control.planning.plan import PhaseKind
from rst_control.types import IN_MOTION, Cause, Reason
from support.figures import Figure

AnyRig = Rig | KinovaRig
STRICT = "kinova_strict, velocities"
PROCESSES = 3
STOPS, LOSSES = 6, 3  # of each kind
SAMPLE_EVERY = 5  # steps of the physics between two samples of shaft and tension
REST = 2e-3  # [rad/s] joints slower than this are at rest
SETS_OFF = 2e-3  # [rad/s] of any joint: the motion has begun
TARGETS = {"tense": 1.0, "pull more": 1.25, "pull less": 1.0}  # [N]
SETTLED = 0.3  # [s] after a command has ended, in which the tension is still measured


@dataclass(frozen=True)
class Carried:
    """One command, carried out."""

    begins: float  # [s] from the command to the first motion of any joint
    lasts: float  # [s] until the controller says that it is done
    rcm_error: float  # [m] largest
    tension: float  # [N] in the end
    peak: float  # [N]


@dataclass(frozen=True)
class Ended:
    """One motion that came to rest other than at its end."""

    speed: float  # [m/s] of the tip before
    time: float  # [s] until the arm rests
    way: float  # [m] that the tip still goes
    rcm_error: float  # [m] largest until then


def measure() -> list[Figure]:
    """All figures, fast first."""
    parts = (_fast, _commands, _stops, _losses)
    with ProcessPoolExecutor(PROCESSES) as pool:
        running = [pool.submit(part) for part in parts]
        return [figure for part in running for figure in part.result()]


def _fast() -> list[Figure]:
    with Rig(load_motion_config(), load_simulation_config()) as rig:
        rig.wake()
        figures = _session("fast", rig)
        return figures + _ended("fast: stop", [_stop(rig, k) for k in range(STOPS)])


def _commands() -> list[Figure]:
    with _ready() as rig:
        figures = _session(STRICT, rig)
        lag = rig.bridge.take_health().lag
        return [*figures, Figure(f"{STRICT}: lag of the arm as seen", lag * 1e3, "ms")]


def _stops() -> list[Figure]:
    with _ready() as rig:
        return _ended(f"{STRICT}: stop", [_stop(rig, k) for k in range(STOPS)])


def _losses() -> list[Figure]:
    what: tuple[tuple[Loss, str], ...] = (
        ("controller", "set-points end (controller lost)"),
        ("feedback", "feedback lost"),
        ("bridge", "bridge lost, stopped by the guard"),
    )
    figures: list[Figure] = []
    with _ready() as rig:
        for loss, words in what:
            ended = [_lose(rig, loss, 100 + k) for k in range(LOSSES)]
            figures += _ended(f"{STRICT}: {words}", ended)
    return figures


def _ready() -> KinovaRig:
    rig = KinovaRig(kinova_motion())
    rig.run(0.3)
    rig.home()
    rig.give("hey robot")
    return rig


# All seven commands.


def _session(name: str, rig: AnyRig) -> list[Figure]:
    figures: list[Figure] = []
    for words in ("tense", "pull more", "pull less", "release", "terminate", "hey robot"):
        done = carry_out(rig, words)
        if words in ("terminate", "hey robot"):  # nothing moves
            continue
        note = f"(took {done.lasts:.2f} s)"
        figures.append(Figure(f"{name}: {words}: to motion", done.begins * 1e3, "ms", note=note))
        figures.append(
            Figure(f"{name}: {words}: RCM error max", done.rcm_error * 1e6, "um", 1000.0)
        )
        target = TARGETS.get(words)
        if target is not None:
            off = abs(done.tension - target)
            over = done.peak - target if words != "pull less" else 0.0
            figures.append(Figure(f"{name}: {words}: tension error", off, "N", 0.06))
            if words != "pull less":
                figures.append(Figure(f"{name}: {words}: overshoot", max(0.0, over), "N", 0.1))
    return figures


def carry_out(rig: AnyRig, words: str) -> Carried:
    """Give one command and wait for its end.

    Raises:
        RuntimeError: It was refused, or did not succeed.
    """
    begun, begins = rig.robot.now, [float("nan")]
    errors, tensions, steps = [0.0], [0.0], itertools.count()

    def each() -> None:
        if np.isnan(begins[0]) and np.abs(rig.robot.reading.velocity).max() > SETS_OFF:
            begins[0] = rig.robot.now - begun
        if next(steps) % SAMPLE_EVERY == 0:
            errors.append(rig.rcm_error)
            tensions.append(float(np.linalg.norm(rig.robot.force)))

    pending = rig.give(words)
    reply = pending.reply.result(0)
    if not reply.accepted:
        raise RuntimeError(f'"{words}" was refused: {reply.message}')
    _until(rig, pending.ended.done, each)
    outcome, lasts = pending.ended.result(0), rig.robot.now - begun
    if outcome.kind != "succeeded":
        raise RuntimeError(f'"{words}" {outcome.kind}: {outcome.message}')
    until = rig.robot.now + SETTLED
    _until(rig, lambda: rig.robot.now >= until, each)
    return Carried(begins[0], lasts, max(errors), tensions[-1], max(tensions))


def _until(rig: AnyRig, done: Callable[[], bool], each: Callable[[], None]) -> None:
    end = rig.robot.now + 300.0
    while not done():
        rig.tick(each)
        if rig.robot.now > end:
            raise RuntimeError("it never ended")


# Stops and losses in motion.


def _stop(rig: AnyRig, number: int) -> Ended:
    """Say "stop" at a random moment of the way to the tissue."""
    _set_off(rig, number)
    return _watch(rig, lambda: rig.executor.stop(Cause(Reason.STOP_TOPIC, "bench"), rig.robot.now))


def _lose(rig: KinovaRig, loss: Loss, number: int) -> Ended:
    _set_off(rig, number)
    ended = _watch(rig, lambda: setattr(rig, "lost", loss))
    rig.lost = None
    return ended


def _set_off(rig: AnyRig, number: int) -> None:
    """Be in motion along the way to the tissue, at a random place."""
    rng = np.random.default_rng(number)
    rig.run(0.5)
    rig.give("hey robot")
    rig.run(0.1)
    reply = rig.give("tense").reply.result(0)
    if not reply.accepted:
        raise RuntimeError(f'"tense" was refused: {reply.message}')
    share, limit = rng.uniform(0.3, 0.7), rig.config.scene.clearance

    def is_there() -> bool:
        view = rig.executor.snapshot
        if view.motion is None or view.motion.phase is not PhaseKind.REACH:
            return False
        long_enough = view.path is not None and view.path.length > 0.8 * limit
        return long_enough and view.motion.progress >= share

    if not rig.until(is_there, 120.0):
        raise RuntimeError(f"never on the way: {rig.executor.snapshot.mode}")


def _watch(rig: AnyRig, act: Callable[[], None]) -> Ended:
    before = rig.tip
    rig.tick()
    speed = float(np.linalg.norm(rig.tip - before)) / rig.period
    began, start = rig.robot.now, rig.tip
    errors: list[float] = [0.0]
    rests = [np.nan, 0.0]  # [s] since when, and [m] how far it went until then

    steps = itertools.count()

    def each() -> None:
        if next(steps) % SAMPLE_EVERY == 0:
            errors.append(rig.rcm_error)
        if np.abs(rig.robot.reading.velocity[:7]).max() > REST:
            rests[0] = rig.robot.now - began

    act()
    for _ in range(round(1.5 / rig.period)):
        rig.tick(each)
    if rig.executor.snapshot.mode.state in IN_MOTION:
        raise RuntimeError("it does not rest")
    rests[1] = float(np.linalg.norm(rig.tip - start))
    return Ended(speed, rests[0], rests[1], max(errors))


def _ended(name: str, ended: Sequence[Ended]) -> list[Figure]:
    speeds = [e.speed * 1e3 for e in ended]
    note = f"({len(ended)} times, from {min(speeds):.1f} to {max(speeds):.1f} mm/s)"
    times, ways = [e.time * 1e3 for e in ended], [e.way * 1e3 for e in ended]
    error = max(e.rcm_error for e in ended)
    return [
        Figure(f"{name}: time median", float(np.median(times)), "ms", note=note),
        Figure(f"{name}: time max", max(times), "ms", note=note),
        Figure(f"{name}: way median", float(np.median(ways)), "mm"),
        Figure(f"{name}: way max", max(ways), "mm", note=note),
        Figure(f"{name}: RCM error max", error * 1e6, "um", 1000.0, note=note),
    ]

# SPDX-License-Identifier: BSD-3-Clause
"""An arm mounted aslant, on a wall, on the ceiling: triangulation, tension by torques, checks.

The base is tilted, the scene keeps its place in the base frame, and the table lies level below.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from bench.common.resumable import measured
from bench.common.rig import Rig
from bench.kinova.suite import TARGETS, carry_out
from bench.motion import triangulate
from bench.tension.suite import TensionBench
from rst_control.config import (
    URDF_FILE,
    MotionConfig,
    load_motion_config,
    load_simulation_config,
)
from rst_control.config.torque_tension import TorqueTensionConfig, load_torque_tension
from rst_control.kinematics.configuration import robot_joints
from rst_control.kinematics.inverse_dynamics import InverseDynamics
from rst_control.kinematics.mounting import GRAVITY
from rst_control.tension.gravity_check import READINGS, RestTorques
from support.figures import Figure, share

Array = NDArray[np.float64]
TILTS: Final = (0, 30, 45, 90, 180)  # [deg]
AZIMUTH: Final = np.radians(35.0)  # to which the base leans: neither along nor across the arm
TABLE: Final = -1.0  # [m] of the table below the base, where that is not bolted to it
FULL: Final = (1000, 120)  # tissues and trials of tension, at each tilt
TISSUES: Final = int(os.environ.get("BENCH_TISSUES", str(FULL[0])))
TRIALS: Final = int(os.environ.get("BENCH_TRIALS", str(FULL[1])))
STARTS: Final = 100  # for each tilt and each setting of the check at rest


def measure() -> list[Figure]:
    """All figures, tilt by tilt."""
    rests = measured(min(TISSUES / FULL[0], TRIALS / FULL[1]), "of the whole", 1.0)
    return [rests, *(figure for tilt in TILTS for figure in _at(tilt)), *_wrong_settings()]


def down(tilt: float, azimuth: float = AZIMUTH) -> Array:
    """Way of gravity in the base frame where the base leans by a tilt [deg]. Shape (3,)."""
    angle = np.radians(tilt)
    across = np.sin(angle)
    return np.array([across * np.cos(azimuth), across * np.sin(azimuth), -np.cos(angle)])


def mounted(tilt: float) -> MotionConfig:
    """Settings of a site where the base leans by a tilt [deg]."""
    config = load_motion_config()
    if not tilt:
        return config
    way = down(tilt)
    table = replace(config.collision, table_normal=tuple(-way), table_height=TABLE)
    return replace(config, scene=replace(config.scene, gravity=tuple(way)), collision=table)


def _at(tilt: int) -> list[Figure]:
    motion, name = mounted(tilt), f"tilt {tilt} deg"
    tissues = triangulate.measure(motion, TISSUES)[0]
    return [
        replace(tissues, name=f"{name}: {tissues.name}"),
        *_session(name, motion),
        *_tension(name, motion),
        _right_setting(name, down(tilt)),
    ]


def _session(name: str, motion: MotionConfig) -> list[Figure]:
    """All pulls in PyBullet, with gravity as the base has it."""
    with Rig(motion, load_simulation_config()) as rig:
        rig.wake()
        done = {word: carry_out(rig, word) for word in (*TARGETS, "release")}
    off = max(abs(done[word].tension - target) for word, target in TARGETS.items())
    error = max(carried.rcm_error for carried in done.values())
    return [
        Figure(f"{name}: session: RCM error max", error * 1e6, "um", 1000.0),
        Figure(f"{name}: session: tension error max", off, "N", 0.06),
    ]


def _tension(name: str, motion: MotionConfig) -> list[Figure]:
    bench = TensionBench(motion, load_torque_tension())
    try:
        found = [bench.estimate(trial, True, True) for trial in bench.trials(TRIALS)]
    finally:
        bench.close()
    errors, sigmas, invalid = (np.array(row) for row in zip(*found, strict=True))
    is_trusted = invalid == ""
    within = int(np.sum(np.abs(errors) <= 2.0 * sigmas))
    note = "postures and ways, shaft leaning on the trocar"
    name = f"{name}: tension by torques"
    return [
        share(f"{name}: within twice the stated sigma", within, TRIALS, 95.0, note=note),
        share(f"{name}: trusted", int(is_trusted.sum()), TRIALS),
        Figure(
            f"{name}: where trusted, 95 % of errors below",
            float(np.quantile(np.abs(errors[is_trusted]), 0.95)),
            "N",
        ),
    ]


# The check at rest.


def _right_setting(name: str, way: Array) -> Figure:
    config, rng = load_torque_tension(), np.random.default_rng(3)
    refused = sum(bool(_refusal(config, way, way, rng)) for _ in range(STARTS))
    note = "starts with the errors that torque_tension.yaml states"
    return share(f"{name}: starts refused at rest", refused, STARTS, 2.0, at_most=True, note=note)


def _wrong_settings() -> list[Figure]:
    """Settings say upright, the base leans to anywhere."""
    config, upright, figures = load_torque_tension(), down(0), []
    for tilt in (2, 5, 10, 15, *TILTS[1:]):
        rng, refused = np.random.default_rng(4), 0
        for way in _leaning(tilt, rng):
            refused += bool(_refusal(config, upright, way, rng))
        name = f"set upright, tilted {tilt} deg: starts refused at rest"
        target = 99.0 if tilt >= 15 else None  # the arm's own errors hide less
        figures.append(share(name, refused, STARTS, target))
    return figures


def _leaning(tilt: float, rng: np.random.Generator) -> Iterator[Array]:
    for azimuth in rng.uniform(0.0, 2.0 * np.pi, STARTS):
        yield down(tilt, azimuth)


def _refusal(
    config: TorqueTensionConfig, setting: Array, truth: Array, rng: np.random.Generator
) -> str:
    """What the check at rest says of an arm at home whose torques are as wrong as is stated."""
    text, error = URDF_FILE.read_text(encoding="utf-8"), config.error
    q = np.array(load_motion_config().scene.home)
    true = InverseDynamics(text, rng.normal() * error.tool_mass + 0.2, GRAVITY * truth)(q)
    true -= InverseDynamics(text, 0.2, GRAVITY * truth)(q)
    masses = 1.0 + rng.normal(size=7) * np.hypot(error.model, error.gain)
    true += masses * InverseDynamics(text, 0.0, GRAVITY * truth)(q)
    true += rng.normal(size=7) * error.offset + rng.normal(size=7) * error.friction
    check = RestTorques(config, text, tuple(setting))
    for _ in range(READINGS):
        effort = true + rng.normal(size=7) * error.noise
        check.update(robot_joints(q, 0.0), np.zeros(7), effort)
    return check.refusal

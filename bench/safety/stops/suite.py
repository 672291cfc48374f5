# SPDX-License-Identifier: BSD-3-Clause
"""Stops in process: at random moments of every state, from one client and from many.

The real executor, command queue and verification in lock-step with a robot without inertia, 500
ticks to the simulated second. In chunks that are kept under .cache/bench/safety/stops/<key>/, where
the key is made of the controller's code and settings: what was measured before is not measured
again. In the environment: STOPS of them (10,000), and see bench/common/resumable.py.
"""

from __future__ import annotations

import json
import logging
import os
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from bench.common import resumable
from bench.common.rig import Rig
from bench.safety.stops import judge
from bench.safety.stops.judge import JudgedStop
from bench.safety.stops.scenes import SITUATIONS, StopStage, one_stop
from rst_control.config import PACKAGE, load_motion_config, load_simulation_config
from support.figures import Figure

FULL = 10_000
STOPS = int(os.environ.get("STOPS", FULL))
CHUNK = 33  # moments of one chunk: each situation as often as the others
FRESH_AFTER = 3  # situations in a row that could not be brought about: another robot is taken
BESIDE = ("ros", "kinova", "host")  # rooms whose code no stop in process comes to
OWN = ("suite.py", "judge.py", "scenes.py")


def measure() -> list[Figure]:
    """Stop until there are enough stops, with those of earlier goes."""
    stops, failures = gather(resumable.CACHE / "safety" / "stops" / key(), STOPS)
    period = 1.0 / load_motion_config().controller.rate
    figures = judge.figures("in process", stops, STOPS, period)
    note = f"({failures[0]})" if failures else ""
    return [
        resumable.measured(len(stops), "stops", FULL),
        *figures,
        Figure("in process: situations not brought about", len(failures), "", note=note),
    ]


def key() -> str:
    """Names the code and the settings that the stops depend on."""
    source = PACKAGE / "src" / "rst_control"
    files = [p for p in source.rglob("*.py") if p.relative_to(source).parts[0] not in BESIDE]
    files += [*PACKAGE.glob("config/*.yaml"), *(Path(__file__).parent / name for name in OWN)]
    return resumable.digest([(file.name, file.read_bytes()) for file in sorted(files)])


def gather(folder: Path, count: int) -> tuple[list[JudgedStop], list[str]]:
    """Stops of as many chunks as it takes, kept ones first; and what could not be brought about.

    Args:
        folder: Where chunks are kept.
        count: Stops to have at least.
    """
    stops: list[JudgedStop] = []
    failures: list[str] = []
    jobs = ((n, folder / f"{n:05d}.json") for n in range(count))  # a chunk has one stop or more
    with resumable.pool(resumable.JOBS, _quieten) as pool:
        for path in resumable.carried_out("stops", jobs, run_chunk, pool):
            found, failed = json.loads(path.read_text(encoding="utf-8"))
            stops += [JudgedStop(**fields) for fields in found]
            failures += failed
            if len(stops) >= count:
                break
    return stops, failures


def _quieten() -> None:
    logging.getLogger("rosout.rst_control.executor").setLevel(logging.CRITICAL)  # made-up errors


def run_chunk(number: int) -> tuple[list[dict[str, Any]], list[str]]:
    """Stops at moments that the chunk's number decides, each situation equally often."""
    rng = np.random.default_rng((6, number))
    motion, simulation = load_motion_config(), load_simulation_config()
    order = [name for _ in range(-(-CHUNK // len(SITUATIONS))) for name in SITUATIONS]
    waiting = [str(name) for name in rng.permutation(order[:CHUNK])]
    stops: list[JudgedStop] = []
    failures: list[str] = []
    while waiting:
        with Rig(motion, simulation, is_light=True) as rig:
            rig.wake()
            stage, failed = StopStage(rig, rng), 0
            while waiting and failed < FRESH_AFTER:
                situation = waiting.pop()
                try:
                    stops += one_stop(stage, situation)
                    failed = 0
                except RuntimeError as error:
                    failures.append(f"{situation}: {error}")
                    failed += 1
    return [asdict(stop) for stop in stops], failures

# SPDX-License-Identifier: BSD-3-Clause
"""Item 1, in process: stops at random moments of every state, from one client and from many.

The real executor, desk and verification in lock-step with a robot without inertia, 500 ticks to the
simulated second. In chunks that are kept under .cache/bench/safety/stops/<key>/, where the key is
made of the controller's code and settings: what was measured before is not measured again. In the
environment: STOPS of them (10,000), JOBS processes, MINUTES after which no chunk is begun.
"""

from __future__ import annotations

import hashlib
import json
import logging
import multiprocessing
import os
import time
from collections.abc import Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from dataclasses import asdict
from pathlib import Path

import numpy as np

from bench.common.rig import Rig
from bench.safety.stops import judge
from bench.safety.stops.judge import Stop
from bench.safety.stops.scenes import SITUATIONS, Stage, one_stop
from rst_control.config import PACKAGE, load_motion_config, load_simulation_config
from support.figures import ROOT, Figure

STOPS = int(os.environ.get("STOPS", "10000"))
JOBS = int(os.environ.get("JOBS") or os.cpu_count() or 1)
MINUTES = float(os.environ.get("MINUTES", "inf"))
CHUNK = 33  # moments of one chunk: each situation as often as the others
FRESH_AFTER = 3  # situations in a row that could not be brought about: another robot is taken
BESIDE = ("ros", "kinova", "host")  # rooms whose code no stop in process comes to
FOLDER = ROOT / ".cache" / "bench" / "safety" / "stops"
OWN = ("suite.py", "judge.py", "scenes.py")


def measure() -> list[Figure]:
    """Stop until there are enough stops, with those of earlier goes."""
    folder = FOLDER / key()
    folder.mkdir(parents=True, exist_ok=True)
    stops, failures = gather(folder, STOPS, JOBS, MINUTES)
    period = 1.0 / load_motion_config().controller.rate
    figures = judge.figures("in process", stops, STOPS, period)
    note = f"({failures[0]})" if failures else ""
    return [
        *figures,
        Figure("in process: situations not brought about", len(failures), "", note=note),
    ]


def key() -> str:
    """Names the code and the settings that the stops depend on."""
    source = PACKAGE / "src" / "rst_control"
    files = [p for p in source.rglob("*.py") if p.relative_to(source).parts[0] not in BESIDE]
    files += [*PACKAGE.glob("config/*.yaml"), *(Path(__file__).parent / name for name in OWN)]
    digest = hashlib.sha256()
    for file in sorted(files):
        digest.update(file.name.encode() + file.read_bytes())
    return digest.hexdigest()[:16]


def gather(folder: Path, count: int, jobs: int, minutes: float) -> tuple[list[Stop], list[str]]:
    """Stops of as many chunks as it takes, kept ones first; and what could not be brought about.

    Args:
        folder: Where chunks are kept.
        count: Stops to have at least.
        jobs: Processes.
        minutes: After which no chunk is begun.
    """
    end = time.monotonic() + 60.0 * minutes
    stops: list[Stop] = []
    failures: list[str] = []
    for chunk in _chunks(folder, count, jobs, end):
        found, failed = json.loads(chunk.read_text(encoding="utf-8"))
        stops += [Stop(**fields) for fields in found]
        failures += failed
        if len(stops) >= count:
            break
    return stops, failures


def _chunks(folder: Path, count: int, jobs: int, end: float) -> Iterator[Path]:
    """Files of the chunks, in their order: made in other processes where they are missing."""
    context = multiprocessing.get_context("spawn")
    most = max(1, count)  # each chunk holds one stop or more
    with ProcessPoolExecutor(jobs, mp_context=context) as pool:
        under_way: dict[Future[None], Path] = {}
        for number in range(most):
            path = folder / f"{number:05d}.json"
            if path.is_file():
                yield path
                continue
            while len(under_way) >= jobs:
                yield from _done(under_way)
            if time.monotonic() > end:
                break
            under_way[pool.submit(make_chunk, number, path)] = path
        while under_way:
            yield from _done(under_way)


def _done(under_way: dict[Future[None], Path]) -> Iterator[Path]:
    finished, _ = wait(under_way, return_when=FIRST_COMPLETED)
    for future in finished:
        future.result()
        yield under_way.pop(future)


def make_chunk(number: int, path: Path, moments: int = CHUNK) -> None:
    """Measure one chunk and keep it."""
    stops, failures = run_chunk(number, moments)
    written = json.dumps([[asdict(stop) for stop in stops], failures])
    unfinished = path.with_suffix(f".{os.getpid()}.part")
    unfinished.write_text(written, encoding="utf-8")
    unfinished.replace(path)


def run_chunk(number: int, moments: int) -> tuple[list[Stop], list[str]]:
    """Stops at moments that the chunk's number decides, each situation equally often."""
    logging.getLogger("rosout.rst_control.executor").setLevel(logging.CRITICAL)  # made-up errors
    rng = np.random.default_rng((6, number))
    motion, simulation = load_motion_config(), load_simulation_config()
    order = [name for _ in range(-(-moments // len(SITUATIONS))) for name in SITUATIONS]
    waiting = [str(name) for name in rng.permutation(order[:moments])]
    stops: list[Stop] = []
    failures: list[str] = []
    while waiting:
        with Rig(motion, simulation, is_light=True) as rig:
            rig.wake()
            stage, failed = Stage(rig, rng), 0
            while waiting and failed < FRESH_AFTER:
                situation = waiting.pop()
                try:
                    stops += one_stop(stage, situation)
                    failed = 0
                except RuntimeError as error:
                    failures.append(f"{situation}: {error}")
                    failed += 1
    return stops, failures

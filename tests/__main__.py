# SPDX-License-Identifier: BSD-3-Clause
"""`make test`: all tests; `--fast`, for `make check`: those that need no node and little time.

The demo comes first, with nothing beside it: recognition that waits for a core counts as one that
hangs, and cores may be threads of one core. Then come the other systems that hear, one at a time.
The tests without nodes, and those that only read launch files or wait for no time, run on every
core beside these, at a lower priority. Last come the systems that hear nothing, with nothing beside
them: a motion that nodes lead in time needs its turns. They mostly wait, so some run at once, fewer
on slow cores. With other arguments: one pytest with them.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path, PurePosixPath
from xml.etree import ElementTree

from typed_config.priority import set_priority

ROOT = Path(__file__).resolve().parents[1]
RESULTS = ROOT / ".cache" / "tests"  # files of JUnit's form
BESIDE = RESULTS / "others.log"  # what the tests beside printed
WITH_NODES = ("rostest", "integration")
DEMO = ("integration/test_end_to_end.py",)  # all nodes, a browser and two pictures
HEARING = (
    "integration/test_language.py",  # Whisper base, where `make languages` fetched it
    "integration/test_paper.py",
    "integration/test_session_replay.py",
    "integration/test_two_namespaces.py",  # hears nothing, but starts two systems
    "rostest/voice",
    "rostest/kinova/kinova_torques.test",  # hears nothing; a tension that comes late is none
    "integration/test_install_space.py",  # built beside those before it
)
WITHOUT = ("state_search", "simulation", "property", "docs", "traps", "unit", "launch")
CORES = len(os.sched_getaffinity(0))
SYSTEMS, FEW = 4, 2  # that run at once; few on slow cores
QUICK = 3.3  # [s] that few of the simulated robot's example take at once; on slow cores: more
SPREAD = ("--dist", "loadfile", "--no-loadscope-reorder")  # what a file's tests share is made once
MOST_FIRST = "--loadscope-reorder"  # files with the most tests
NICE = 19  # of the tests without nodes
SLOWEST = 20
KINDS = ("test_*.py", "*.test")  # names of files of tests
COUNTS = ("passed", "failed", "skipped")


def main(arguments: Sequence[str]) -> int:
    """Run them; 0 when all passed."""
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # else each process compiles all modules anew
    RESULTS.mkdir(parents=True, exist_ok=True)
    if arguments == ["--fast"]:
        _compile_kernels()
        fast = subprocess.call(_command("fast", (*WITHOUT, *WITH_NODES), CORES, "-m", "not slow"))
        return _conclude(["fast"], [fast])
    if arguments:
        return subprocess.call(_pytest(*_places(arguments), *arguments))
    _compile_kernels()
    systems = _systems_at_once()
    print("The demo first, then what hears; tests beside it are shown afterwards.", flush=True)
    codes = [subprocess.call(_command("demo", DEMO, 1))]
    others = _start_beside()
    try:
        codes += [subprocess.call(_command("hearing", HEARING, 1))]
        codes += [others.wait()]
    finally:
        if others.poll() is None:
            os.killpg(others.pid, signal.SIGINT)  # as Ctrl-C, so that its nodes are ended
            others.wait()
        print(BESIDE.read_text(encoding="utf-8", errors="replace"), flush=True)
    codes += [subprocess.call(_command("systems", deaf_systems(), systems, MOST_FIRST))]
    return _conclude(["demo", "hearing", "others", "systems"], codes)


def deaf_systems() -> list[str]:
    """Files of tests with nodes, without those that hear."""
    folder = ROOT / "tests"
    found = [p for top in WITH_NODES for kind in KINDS for p in (folder / top).rglob(kind)]
    places = sorted(path.relative_to(folder).as_posix() for path in found)
    alone = {*DEMO, *HEARING}
    return [p for p in places if not {p, *map(str, PurePosixPath(p).parents)} & alone]


def _start_beside() -> subprocess.Popen[bytes]:
    """Begin the tests without nodes, whose output goes to a file."""
    with BESIDE.open("wb") as file:
        return subprocess.Popen(
            _command("others", WITHOUT, CORES),
            stdout=file,
            stderr=subprocess.STDOUT,
            preexec_fn=give_way,
        )


def _conclude(names: Sequence[str], codes: Sequence[int]) -> int:
    """Show the slowest tests and how many passed; gives the exit code."""
    results = [RESULTS / f"{name}.xml" for name in names]
    print(f"slowest {SLOWEST}, also in {RESULTS}:")
    for seconds, test in slowest(results):
        print(f"{seconds:7.2f} s  {test}")
    total = count(results)
    print(", ".join(f"{total[name]} {name}" for name in COUNTS))
    return int(any(codes))


def count(results: Sequence[Path]) -> dict[str, int]:
    """Tests that passed, failed and were skipped, of those files that are there."""
    suites = [suite for file in results for suite in _tree(file).iter("testsuite")]
    sums = {key: sum(int(suite.get(key, 0)) for suite in suites) for key in _KEYS}
    failed, skipped = sums["failures"] + sums["errors"], sums["skipped"]
    passed = sums["tests"] - failed - skipped
    return dict(zip(COUNTS, (passed, failed, skipped), strict=True))


def slowest(results: Sequence[Path]) -> list[tuple[float, str]]:
    """Seconds and name of the slowest tests, the slowest first; set-up and tear-down count."""
    cases = [case for file in results for case in _tree(file).iter("testcase")]
    times = [(float(c.get("time", 0)), f"{c.get('classname')}::{c.get('name')}") for c in cases]
    return sorted(times, reverse=True)[:SLOWEST]


_KEYS = ("tests", "failures", "errors", "skipped")


def _tree(file: Path) -> ElementTree.Element:
    return ElementTree.parse(file).getroot() if file.is_file() else ElementTree.Element("none")


def _compile_kernels() -> None:
    """Once for all: what starts while they are compiled would compile them for itself."""
    _move_robot().wait()


def _systems_at_once() -> int:
    """How many systems the cores carry."""
    began = time.monotonic()
    for robot in [_move_robot() for _ in range(FEW)]:
        robot.wait()
    seconds = time.monotonic() - began
    systems = SYSTEMS if seconds <= QUICK else FEW
    print(f"The robot moved {FEW} times at once in {seconds:.1f} s: systems at once: {systems}")
    return systems


def _move_robot() -> subprocess.Popen[bytes]:
    """Begin to simulate a few seconds of its motion, as fast as a core computes them."""
    script = ROOT / "examples" / "move_simulated_robot.py"
    return subprocess.Popen([sys.executable, script], stdout=subprocess.DEVNULL)


def _pytest(*words: str) -> list[str]:
    return [sys.executable, "-m", "pytest", *words]


def _command(name: str, places: Sequence[str], workers: int, *more: str) -> list[str]:
    """Pytest over places in tests/ in so many processes, with its results in a file of the name."""
    results = RESULTS / f"{name}.xml"
    results.unlink(missing_ok=True)
    paths = [str(ROOT / "tests" / place) for place in places]
    return _pytest(*paths, f"--junitxml={results}", "-n", str(workers), *SPREAD, *more)


def _places(arguments: Sequence[str]) -> list[str]:
    """All tests, unless the arguments name some by their paths."""
    named = [word for word in arguments if Path(word.partition("::")[0]).exists()]
    return [] if named else [str(ROOT / "tests")]


def give_way() -> None:
    """In the child: lower its priority, and that of a session of its own."""
    os.setsid()
    set_priority(NICE)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

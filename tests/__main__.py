# SPDX-License-Identifier: BSD-3-Clause
"""`make test`: all tests in two processes side by side, those with running nodes and the others.

Tests with nodes mostly wait, so the others take what they leave of the machine, at a lower
priority. With arguments: one pytest over all tests, with them.
"""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from xml.etree import ElementTree

FOLDER = Path(__file__).resolve().parent
WITH_NODES = ("integration", "rostest")
WITHOUT = ("simulation", "property", "traps", "unit")
NICE = 19  # of the tests without nodes
COUNTS = ("passed", "failed", "skipped")


def main(arguments: Sequence[str]) -> int:
    """Run them; 0 when all passed."""
    pytest = [sys.executable, "-m", "pytest"]
    if arguments:
        return subprocess.call([*pytest, str(FOLDER), *arguments])
    with tempfile.TemporaryDirectory() as scratch:
        log, results = Path(scratch) / "log", [Path(scratch) / name for name in ("a.xml", "b.xml")]
        print("Tests with nodes first; the others run beside them and are shown last.", flush=True)
        with log.open("wb") as file:
            other = subprocess.Popen(
                [*pytest, *_paths(WITHOUT), f"--junitxml={results[0]}"],
                stdout=file,
                stderr=subprocess.STDOUT,
                preexec_fn=_give_way,
            )
        try:
            first = subprocess.call([*pytest, *_paths(WITH_NODES), f"--junitxml={results[1]}"])
            second = other.wait()
        finally:
            _end(other)
            print(log.read_text(encoding="utf-8", errors="replace"), flush=True)
        _tell([count(file) for file in results])
    return 1 if first or second else 0


def count(results: Path) -> dict[str, int]:
    """Tests that passed, failed and were skipped, of a file of JUnit's form; empty: no file."""
    if not results.is_file():
        return {}
    (suite,) = ElementTree.parse(results).iter("testsuite")
    failed = int(suite.get("failures", 0)) + int(suite.get("errors", 0))
    skipped = int(suite.get("skipped", 0))
    passed = int(suite.get("tests", 0)) - failed - skipped
    return dict(zip(COUNTS, (passed, failed, skipped), strict=True))


def _end(process: subprocess.Popen[bytes]) -> None:
    """End it, and what it started, where it still runs."""
    if process.poll() is None:
        os.killpg(process.pid, signal.SIGTERM)


def _tell(counts: Sequence[dict[str, int]]) -> None:
    total = {name: sum(one.get(name, 0) for one in counts) for name in COUNTS}
    print(", ".join(f"{total[name]} {name}" for name in COUNTS))


def _paths(folders: Sequence[str]) -> list[str]:
    return [str(FOLDER / name) for name in folders]


def _give_way() -> None:
    """In the child: lower its priority, and that of its session, which Linux weighs as a whole."""
    os.nice(NICE)
    os.setsid()
    with contextlib.suppress(OSError):  # a kernel without groups of sessions
        Path("/proc/self/autogroup").write_text(str(NICE), encoding="ascii")


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

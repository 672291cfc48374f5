# SPDX-License-Identifier: BSD-3-Clause
"""`make test`: all tests in two processes side by side, those with running nodes and the others.

Tests with nodes mostly wait, so the others take what they leave of the machine, at a lower
priority. A robot holds where its machine does not keep up, so what failed in that crowd is run once
more with nothing beside it; both outcomes are shown, the second counts. With arguments: one
pytest over all tests, with them.
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
TESTS_FAILED = 1  # pytest's exit code; others mean that not all of them were run
MOST_AGAIN = 5  # failures beyond which the crowd is not to blame


def main(arguments: Sequence[str]) -> int:
    """Run them; 0 when all passed."""
    pytest = [sys.executable, "-m", "pytest"]
    if arguments:
        return subprocess.call([*pytest, str(FOLDER), *arguments])
    with tempfile.TemporaryDirectory() as scratch:
        log, failed = Path(scratch) / "log", Path(scratch) / "failed"
        results = [Path(scratch) / name for name in ("a.xml", "b.xml", "again.xml")]
        print("Tests with nodes first; the others run beside them and are shown last.", flush=True)
        environment = {**os.environ, "FAILED_TESTS": str(failed)}
        with log.open("wb") as file:
            other = subprocess.Popen(
                [*pytest, *_paths(WITHOUT), f"--junitxml={results[0]}"],
                stdout=file,
                stderr=subprocess.STDOUT,
                env=environment,
                preexec_fn=_give_way,
            )
        try:
            first = subprocess.call(
                [*pytest, *_paths(WITH_NODES), f"--junitxml={results[1]}"],
                env=environment,
            )
            second = other.wait()
        finally:
            _end(other)
            print(log.read_text(encoding="utf-8", errors="replace"), flush=True)
        again = _to_run_again(failed) if {first, second} <= {0, TESTS_FAILED} else []
        if again:
            print("Failed beside others, so once more alone:", *again, sep="\n  ", flush=True)
            command = [*pytest, *again, f"--junitxml={results[2]}"]
            first, second = 0, subprocess.call(command, env={**os.environ, "FAILED_TESTS": ""})
        _tell([count(file) for file in results], len(again))
    return 1 if first or second else 0


def _to_run_again(failed: Path) -> list[str]:
    """Tests named in a file, each once; none where it is missing or names too many."""
    if not failed.is_file():
        return []
    names = list(dict.fromkeys(failed.read_text(encoding="utf-8").splitlines()))
    return [str(FOLDER.parent / name) for name in names] if len(names) <= MOST_AGAIN else []


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


def _tell(counts: Sequence[dict[str, int]], again: int) -> None:
    total = {name: sum(one.get(name, 0) for one in counts) for name in COUNTS}
    total["failed"] -= again  # each of them counts as what it came to alone
    print(", ".join(f"{total[name]} {name}" for name in COUNTS), end="")
    print(f"; {again} of them run again alone" if again else "")


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

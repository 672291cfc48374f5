# SPDX-License-Identifier: BSD-3-Clause
"""Fuzz every target, or those named, each in a process of its own: `make fuzz [SECONDS=60]`.

Inputs that led somewhere new are kept in `.cache/fuzz/<target>` and taken up again. An input that
breaks a target is written to `tests/data/crashers/<target>`, from where the tests try it for ever.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
from pathlib import Path

from tests.fuzz.names import NAMES

ROOT = Path(__file__).resolve().parents[2]
CRASHERS = ROOT / "tests" / "data" / "crashers"
LONGEST = 4096  # bytes of an input; what is longer is the business of the tests with huge texts
PATIENCE = 10  # [s] for one input, after which it counts as a hang
MEMORY = 2048  # [MB] above which an input counts as a crasher


def main() -> int:
    """Run; returns 1 where a target broke."""
    parser = argparse.ArgumentParser(prog="make fuzz", description=__doc__)
    parser.add_argument("target", nargs="*", help=f"of {', '.join(NAMES)}; default: all of them")
    parser.add_argument("--seconds", type=int, default=60, help="for each target")
    given = parser.parse_args()
    if unknown := set(given.target) - set(NAMES):
        parser.error(f"no such target: {', '.join(unknown)}; allowed: {', '.join(NAMES)}")
    broken = [name for name in given.target or NAMES if not _holds(name, given.seconds)]
    for name in broken:
        print(f"{name} broke; its input is in {CRASHERS.relative_to(ROOT) / name}")
    return 1 if broken else 0


def _holds(name: str, seconds: int) -> bool:
    corpus, crashers = ROOT / ".cache" / "fuzz" / name, CRASHERS / name
    corpus.mkdir(parents=True, exist_ok=True)
    crashers.mkdir(parents=True, exist_ok=True)
    print(f"--- {name}, {seconds} s", flush=True)
    done = subprocess.run(
        [
            sys.executable,
            "-m",
            "tests.fuzz.one",
            name,
            f"-max_total_time={seconds}",
            f"-max_len={LONGEST}",
            f"-timeout={PATIENCE}",
            f"-rss_limit_mb={MEMORY}",
            f"-artifact_prefix={crashers}/",
            "-print_final_stats=1",
            "-verbosity=0",
            str(corpus),
        ],
        check=False,
    )
    if not any(crashers.iterdir()):
        crashers.rmdir()
    return done.returncode == 0


if __name__ == "__main__":
    sys.exit(main())

# SPDX-License-Identifier: BSD-3-Clause
"""Each part of the running system is killed, or stopped and let go on, in mid-motion.

Controller, simulated robot, voice node, recorder and master are launches of their own, an action
client is a process. In each motion one of them gets SIGKILL or SIGSTOP at a random moment. Judged
is what the joints do, as the robot reports them (where the robot is lost: the set-points that the
controller sends), by the stamps that they carry. Then the part is started anew, or goes
on; nothing may move before "hey robot", and after it the next command must. The recogniser within
the voice node hangs for ever, or raises an error; then a "stop" must still be spotted.

Where the loss stops nothing by design, a stop is given 0.15 to 0.3 s after it, by topic or service.
Every loss is kept in bench/results/safety/losses_rows/ with a digest of the code that decides on
it, so that a second go continues the first. In the environment: LOSSES in all (60; 1000 for the
record), VICTIMS to take (all), MINUTES after which none is begun.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from dataclasses import asdict
from functools import cache
from pathlib import Path

from bench.common import resumable
from bench.safety.losses import judge
from bench.safety.losses.judge import PartLoss, left, ways_of
from bench.safety.losses.stage import RULES, stage_for
from support.figures import RESULTS, ROOT, Figure
from support.product_code import SYSTEM, identity

FULL = 1000  # losses
LOSSES = int(os.environ.get("LOSSES", "60"))
VICTIMS = tuple(os.environ.get("VICTIMS", " ".join(RULES)).split())
PATIENCE = 3  # goes in a row from which nothing comes
FOLDER = RESULTS / "safety" / "losses_rows"
LOGS = ROOT / ".cache" / "bench" / "safety" / "losses"


def measure() -> list[Figure]:
    """Lose parts until each was lost often enough; figures are of all losses that are kept.

    Raises:
        RuntimeError: The system did not start, or came to no loss.
    """
    LOGS.mkdir(parents=True, exist_ok=True)
    end = time.monotonic() + 60.0 * resumable.MINUTES
    each = -(-LOSSES // sum(len(ways_of(victim)) for victim in RULES))
    for victim in VICTIMS:
        fruitless = 0
        while _wanting(victim, each) and time.monotonic() < end:
            fruitless = 0 if _has_come_of_it(victim, each, end) else fruitless + 1
            if fruitless == PATIENCE:
                raise RuntimeError(
                    f"no loss of the {victim} in {PATIENCE} goes; see {_log(victim)}"
                )
    losses = [loss for victim in RULES for loss in _so_far(victim)]
    return judge.figures(losses, RULES, FULL)


@cache
def key() -> str:
    """Names the code and settings that losses depend on, as this process began."""
    return resumable.digest(identity(SYSTEM), resumable.code(Path(__file__).parent))


def _kept(victim: str) -> Path:
    return FOLDER / f"{victim}.jsonl"


def _so_far(victim: str) -> list[PartLoss]:
    return [PartLoss.from_json(row) for row in resumable.rows_of(_kept(victim), key())]


def _log(victim: str) -> Path:
    return LOGS / f"{victim}.log"


def _wanting(victim: str, each: int) -> list[str]:
    """Ways that are still to be taken, once for each time."""
    return left(victim, _so_far(victim), dict.fromkeys(ways_of(victim), each))


def _has_come_of_it(victim: str, each: int, end: float) -> bool:
    """One go in a process of its own, for rospy knows one master in its life."""
    before = len(_so_far(victim))
    words = (sys.executable, "-m", "bench.safety.losses.suite", victim, str(each), str(end))
    subprocess.run(words, cwd=ROOT, check=False)
    return len(_so_far(victim)) > before


def _lose(victim: str, each: int, end: float) -> None:
    """Lose one part again and again, and keep each loss."""
    with stage_for(victim, len(_so_far(victim)), _log(victim)) as stage:
        while (ways := _wanting(victim, each)) and time.monotonic() < end:
            loss = stage.lose(ways[0])
            resumable.append(_kept(victim), key(), asdict(loss))
            if loss.back is None or not loss.found:
                return  # the next must not be judged by what this one has broken


if __name__ == "__main__":
    _lose(sys.argv[1], int(sys.argv[2]), float(sys.argv[3]))

# SPDX-License-Identifier: BSD-3-Clause
"""Item 2: each part of the running system is killed, or stopped and let go on, in mid-motion.

Controller, simulated robot, voice node, recorder and master are launches of their own, an action
client is a process. In each motion one of them gets SIGKILL or SIGSTOP at a random moment. Judged
is what the joints do, as the robot reports them (where the robot is lost: the set-points that the
controller sends), by the stamps that they carry. Then the part is started anew, or goes
on; nothing may move before "hey robot", and after it the next command must. The recogniser within
the voice node hangs for ever, or raises an error; then a "stop" must still be spotted.

Where the loss stops nothing by design, a stop is given 0.15 to 0.3 s after it, by topic or service.
Results are kept under .cache/bench/safety/losses/<key>/, where the key is made of the code that
decides on a loss, so that a second go continues the first. In the environment: LOSSES in all (60),
VICTIMS to take (all), MINUTES after which none is begun.
"""

from __future__ import annotations

import hashlib
import json
import os
import subprocess
import sys
import time
from dataclasses import asdict
from pathlib import Path

from bench.figures import ROOT, Figure
from bench.safety import losses_judge as judge
from bench.safety.losses_judge import Loss, left, ways_of
from bench.safety.losses_stage import RULES, stage_for

LOSSES = int(os.environ.get("LOSSES", "60"))
MINUTES = float(os.environ.get("MINUTES", "inf"))
VICTIMS = tuple(os.environ.get("VICTIMS", " ".join(RULES)).split())
PATIENCE = 3  # goes in a row from which nothing comes
CORE = "executor heartbeat keep lifecycle motion mover phase_runs presence processes profile waking"
EDGE = (
    "action_server command_service controller_node peers presence_watch recording_link "
    "registrar_node"
)
CONCERNED = (  # what decides how soon the robot rests, and how it comes back
    *(f"rst_control/src/rst_control/{name}.py" for name in CORE.split()),
    *(f"rst_control/src/rst_control/ros/{name}.py" for name in EDGE.split()),
    "rst_control/src/rst_control/watchdogs.py",
    "rst_control/src/rst_control/backends/servo.py",
    *(f"voice_assist/src/voice_assist/ros/{name}.py" for name in ("node", "publishers")),
)
FOLDER = ROOT / ".cache" / "bench" / "safety" / "losses"


def measure() -> list[Figure]:
    """Lose parts until each was lost often enough; figures are of all losses, earlier ones too.

    Raises:
        RuntimeError: The system did not start, or came to no loss.
    """
    folder = FOLDER / key()
    folder.mkdir(parents=True, exist_ok=True)
    end = time.monotonic() + 60.0 * MINUTES
    each = -(-LOSSES // sum(len(ways_of(victim)) for victim in RULES))
    for victim in VICTIMS:
        kept = folder / f"{victim}.jsonl"
        fruitless = 0
        while left(victim, read(kept), each) and time.monotonic() < end:
            fruitless = 0 if _has_come_of_it(victim, kept, each, end) else fruitless + 1
            if fruitless == PATIENCE:
                raise RuntimeError(
                    f"no loss of the {victim} in {PATIENCE} goes; see {kept.stem}.log"
                )
    losses = [loss for victim in RULES for loss in read(folder / f"{victim}.jsonl")]
    planned = each * sum(len(ways_of(victim)) for victim in RULES)
    return judge.figures(losses, RULES, planned)


def key() -> str:
    """Names the code and the settings that the losses depend on."""
    packages = ROOT / "catkin_ws" / "src"
    files = [*Path(__file__).parent.glob("losses_*.py")]
    files += [file for pattern in CONCERNED for file in packages.glob(pattern)]
    digest = hashlib.sha256()
    for file in sorted(files):
        digest.update(file.name.encode() + file.read_bytes())
    return digest.hexdigest()[:16]


def read(kept: Path) -> list[Loss]:
    """Losses that were measured before."""
    if not kept.is_file():
        return []
    fields = [json.loads(line) for line in kept.read_text(encoding="utf-8").splitlines()]
    return [Loss(**{**one, "objections": tuple(one["objections"])}) for one in fields]


def _has_come_of_it(victim: str, kept: Path, each: int, end: float) -> bool:
    """One go in a process of its own, for rospy knows one master in its life."""
    before = len(read(kept))
    words = (sys.executable, "-m", "bench.safety.losses", victim, str(kept), str(each), str(end))
    subprocess.run(words, cwd=ROOT, check=False)
    return len(read(kept)) > before


def _lose(victim: str, kept: Path, each: int, end: float) -> None:
    """Lose one part again and again, and keep each loss."""
    with stage_for(victim, len(read(kept)), kept.with_suffix(".log")) as stage:
        while (ways := left(victim, read(kept), each)) and time.monotonic() < end:
            loss = stage.lose(ways[0])
            with kept.open("a", encoding="utf-8") as lines:
                lines.write(json.dumps(asdict(loss)) + "\n")
            if loss.back is None or not loss.found:
                return  # the next must not be judged by what this one has broken


if __name__ == "__main__":
    _lose(sys.argv[1], Path(sys.argv[2]), int(sys.argv[3]), float(sys.argv[4]))

# SPDX-License-Identifier: BSD-3-Clause
"""Voice on one host, controller and robot on another, and a bad network between them.

Two network namespaces are the hosts, each with a TUN device; `relay.py` is all that joins
them: link cut, 500 ms delay, 20 % loss, one way only, another address. A spoken motion is under way
at each fault, at a random phase of it. Counted is the time until the set-points of arm and tool
rest: from the fault on, where no "stop" could reach the robot any more; from a "stop" that is said,
where it could. Then nothing may move until "hey robot", and after it the next command has to work.

The voice node here (`voice.py`) has its own publishers, caller and heartbeat, but no recognition.
Needs root, iproute2 and TUN; where one of them is missing, it says so and measures nothing. In the
environment: TRIALS of each fault (10), INTERVAL between two heartbeats [s] (the voice node's), AGE
of the last one that is allowed [s] (that of launch/two_hosts.yaml).
"""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
import tempfile
from pathlib import Path

from bench.common.resumable import measured
from bench.safety.network import judge
from bench.safety.network.faults import FAULTS
from bench.safety.network.hosts import Hosts, missing, on
from bench.safety.network.judge import NetworkTrial
from support.figures import ROOT, Figure

FULL = 10  # trials of each fault
TRIALS = os.environ.get("TRIALS", str(FULL))
AGE = os.environ.get("AGE", "two_hosts")


def measure() -> list[Figure]:
    """Inflict each fault as often as asked for.

    Raises:
        RuntimeError: The system did not start, or a part of it ended.
    """
    lacking = missing()
    if lacking:
        print(f"two hosts are not measured: {lacking}")
        skipped = Figure("two hosts: trials", 0.0, "", note=f"(skipped: {lacking})")
        return [measured(0.0, "of each fault", FULL), skipped]
    from voice_assist.ros.voice_node import HEARTBEAT  # takes torch with it

    interval = os.environ.get("INTERVAL", str(HEARTBEAT))
    with tempfile.TemporaryDirectory() as name, Hosts() as hosts:
        result = Path(name) / "trials"
        words = [hosts.robot, hosts.voice, str(result), TRIALS, interval, AGE]
        command = [sys.executable, "-m", "bench.safety.network.session", *words]
        done = subprocess.run(on(hosts.robot, command), cwd=ROOT, check=False)
        if done.returncode or not result.exists():
            raise RuntimeError(f"the session on two hosts ended with {done.returncode}")
        trials, void = _read(result)
    age = "as in launch/two_hosts.yaml" if AGE == "two_hosts" else f"{float(AGE):g} s"
    note = f"(a heartbeat each {float(interval) * 1e3:.0f} ms, allowed age {age})"
    rests = measured(len(trials) / len(FAULTS), "of each fault", FULL)
    return [rests, *judge.figures(trials, void, note)]


def _read(result: Path) -> tuple[list[NetworkTrial], int]:
    trials, void = pickle.loads(result.read_bytes())  # written by the process just ended
    return list(trials), int(void)

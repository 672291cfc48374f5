# SPDX-License-Identifier: BSD-3-Clause
"""The wall clock of the running robot, of the controller, or of both is set in mid-motion.

Messages are stamped by it; control and watchdogs go by the steady clock. It is set for single
processes (`other_clock`), so that the machine keeps its own.
"""

import json
import os
import re
import sys
from collections import Counter
from pathlib import Path

from support.waiting import wait_until
from tests.support.ros_host import ROSTEST

PROGRAMS = Path(__file__).parent / "programs"
CLOCK = PROGRAMS / "other_clock"
STEP = 5e-3  # [rad] that no joint goes from one joint state to the next, 2 ms later
HELD = 1e-5  # [rad] that it may go while it is held
RCM = 1e-5  # [m]


def test_at_worst_it_holds_names_it_and_goes_on_after_hey_robot(host, tmp_path):
    results, clocks = tmp_path / "seen.json", {n: tmp_path / n for n in ("robot", "controller")}
    path = f"{CLOCK}{os.pathsep}{os.environ.get('PYTHONPATH', '')}"
    more = {"robot": {}, "controller": {"on_recording_loss": "ignore"}}
    host.start_master()
    for name, clock in clocks.items():
        clock.write_text("0", encoding="utf-8")
        overrides = ROSTEST / f"patient_{name}.yaml"
        beside = {"WALL_CLOCK": str(clock), "PYTHONPATH": path}
        host.launch(name, beside, overrides=overrides, **more[name])
    witness = host.start(
        sys.executable,
        str(PROGRAMS / "clock_witness.py"),
        *map(str, clocks.values()),
        str(results),
    )
    wait_until(lambda: witness.poll() is not None, "a robot that was watched", limit=240.0)
    said = host.said()
    assert witness.returncode == 0, said[-3000:]
    found = json.loads(results.read_text(encoding="utf-8"))
    assert Counter(one["whose"] for one in found) == {"both": 6, "robot": 4, "controller": 4}
    for one in found:
        assert one["state"] in ("moving", "active", "halted", "faulted"), one
        assert one["reason"] or one["state"] in ("moving", "active"), one
        assert 'say "hey robot"' in one["refused"], one
        assert one["drift"] < HELD and one["step"] < STEP and one["rcm"] < RCM, one
    jumps = {f"{one['jump']:+.1f}" for one in found}
    told = re.findall(r"the wall clock was set by (\S+) s", said)
    assert {f"{float(one):+.1f}" for one in told} == jumps
    assert {one["whose"] for one in found if one["state"] == "faulted"} == {
        *("both", "robot", "controller")
    }

# SPDX-License-Identifier: BSD-3-Clause
"""The wall clock of the running robot, of the controller, or of both is set in mid-motion.

Messages are stamped by it; control and watchdogs go by the steady clock. It is set for single
processes (`other_clock`), so that the machine keeps its own. A Kinova arm: test_killed_bridge.py.
"""

import json
import os
import re
import sys
from collections import Counter
from pathlib import Path

from support.waiting import wait_until
from tests.support.ros_host import ASK, ROSTEST

PROGRAMS = Path(__file__).parent / "programs"
CLOCK = PROGRAMS / "other_clock"
JUMPS = {"both": (0.3, 30.0, -3.0), "robot": (30.0, -3.0), "controller": (30.0, -3.0)}  # [s]
WATCHED = 280.0  # [s] for all jumps on a loaded machine
STEP = 5e-3  # [rad] that no joint goes from one joint state to the next, 8 ms later
HELD = 1e-5  # [rad] that it may go while it is held
RCM = 1e-5  # [m]


def test_at_worst_it_holds_names_it_and_goes_on_after_hey_robot(host, tmp_path):
    clocks = {name: tmp_path / name for name in ("robot", "controller")}
    more = {"robot": {}, "controller": {"on_recording_loss": "ignore"}}
    host.start_master()
    for name, clock in clocks.items():
        overrides = ROSTEST / f"patient_{name}.yaml"
        host.launch(name, clock_of(clock), overrides=overrides, **more[name])
    found, said = witnessed(host, tmp_path, JUMPS, clocks.values())
    assert Counter(one["whose"] for one in found) == {"both": 6, "robot": 4, "controller": 4}
    for one in found:
        assert one["drift"] < HELD and one["step"] < STEP and one["rcm"] < RCM, one
    jumps = {f"{one['jump']:+.1f}" for one in found}
    reported = re.findall(r"the wall clock was set by (\S+) s", said)
    assert {f"{float(one):+.1f}" for one in reported} == jumps
    assert {one["whose"] for one in found if one["state"] == "faulted"} == set(JUMPS)


def clock_of(file, **of_nodes):
    """Variables for a launch whose nodes have a wall clock that can be set; some have their own."""
    for each in (file, *of_nodes.values()):
        each.write_text("0", encoding="utf-8")
    more = {f"WALL_CLOCK_{name}": str(each) for name, each in of_nodes.items()}
    path = f"{CLOCK}{os.pathsep}{os.environ.get('PYTHONPATH', '')}"
    return {"WALL_CLOCK": str(file), "PYTHONPATH": path, **more}


def witnessed(host, folder, jumps, clocks):
    """What the witness saw of each jump, and all that was printed."""
    results = folder / "seen.json"
    wait_until(lambda: host.is_found("/rst_control/command"), "a controller", every=ASK)
    witness = host.start(
        sys.executable,
        str(PROGRAMS / "clock_witness.py"),
        json.dumps(jumps),
        *map(str, clocks),
        str(results),
    )
    wait_until(lambda: witness.poll() is not None, "a robot that was watched", limit=WATCHED)
    said = host.said()
    assert witness.returncode == 0, said[-3000:]
    found = json.loads(results.read_text(encoding="utf-8"))
    for one in found:
        assert one["state"] in ("moving", "active", "halted", "faulted"), one
        assert one["reason"] or one["state"] in ("moving", "active"), one
        assert 'say "hey robot"' in one["refused"], one
    return found, said

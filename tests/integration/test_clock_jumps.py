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

import pytest

from support.waiting import wait_until
from tests.support.ros_host import ASK, ROSTEST

PROGRAMS = Path(__file__).parent / "programs"
CLOCK = PROGRAMS / "other_clock"
JUMPS = {"both": (0.06, 0.3, 30.0, -3.0), "robot": (30.0, -3.0), "controller": (30.0, -3.0)}  # [s]
pytestmark = pytest.mark.timeout(600)
WATCHED = 280.0  # [s] for all jumps on a loaded machine
STEP = 5e-3  # [rad] that no joint goes from one joint state to the next, 8 ms later
HELD = 1e-5  # [rad] that it may go while it is held
RCM = 1e-5  # [m]


def test_at_worst_it_holds_names_it_and_goes_on_after_hey_robot(host, tmp_path):
    clocks = {name: tmp_path / name for name in JUMPS}
    more = {"robot": {}, "controller": {"on_recording_loss": "ignore"}}
    host.start_master()
    for name in more:
        overrides = ROSTEST / f"patient_{name}.yaml"
        host.launch(name, clock_of(clocks["both"], clocks[name]), overrides=overrides, **more[name])
    found, said = witnessed(host, tmp_path, JUMPS, clocks)
    assert Counter(one["whose"] for one in found) == {"both": 8, "robot": 4, "controller": 4}
    for one in found:
        assert one["drift"] < HELD and one["step"] < STEP and one["rcm"] < RCM, one
    jumps = {f"{one['jump']:+.1f}" for one in found}
    reported = re.findall(r"the wall clock was set by (\S+) s", said)
    assert {f"{float(one):+.1f}" for one in reported} == jumps
    of_host = {one["jump"]: one for one in found if one["whose"] == "both"}
    for jump in JUMPS["both"]:
        if jump > 0.0:  # set back, a set-point that was on its way is of the future
            assert of_host[jump]["state"] in ("moving", "active"), of_host[jump]
    assert {one["whose"] for one in found if one["state"] == "faulted"} >= {"robot", "controller"}


def clock_of(common, file, **of_nodes):
    """Variables for a launch whose nodes have a wall clock that can be set.

    The first file sets those of all; the second those of the nodes that have no file of their own.
    """
    for each in (common, file, *of_nodes.values()):
        each.write_text("0", encoding="utf-8")
    more = {f"WALL_CLOCK_{name}": f"{common}{os.pathsep}{each}" for name, each in of_nodes.items()}
    path = f"{CLOCK}{os.pathsep}{os.environ.get('PYTHONPATH', '')}"
    return {"WALL_CLOCK": f"{common}{os.pathsep}{file}", "PYTHONPATH": path, **more}


def witnessed(host, folder, jumps, clocks):
    """What the witness saw of each jump, and all that was printed."""
    results = folder / "seen.json"
    wait_until(lambda: host.is_found("/rst_control/command"), "a controller", every=ASK)
    witness = host.start(
        sys.executable,
        str(PROGRAMS / "clock_witness.py"),
        json.dumps(jumps),
        json.dumps({name: str(clocks[name]) for name in jumps}),
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

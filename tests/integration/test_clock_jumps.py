# SPDX-License-Identifier: BSD-3-Clause
"""The wall clock of the running robot, of the controller, or of both is set in mid-motion.

Messages are stamped by it; control and watchdogs go by the steady clock. It is set for single
processes (`other_clock`), so that the machine keeps its own.
"""

import json
import os
import re
import sys
from pathlib import Path

import pytest

from support.waiting import wait_until
from tests.support.ros_host import ROSTEST

PROGRAMS = Path(__file__).parent / "programs"
CLOCK = PROGRAMS / "other_clock"
STEP = 5e-3  # [rad] that no joint goes from one joint state to the next, 2 ms later
HELD = 1e-5  # [rad] that it may go while it is held
RCM = 1e-5  # [m]


@pytest.mark.parametrize("whose", ["robot and controller", "robot", "controller"])
def test_at_worst_it_holds_names_it_and_goes_on_after_hey_robot(host, tmp_path, whose):
    clock, results = tmp_path / "clock", tmp_path / "seen.json"
    clock.write_text("0", encoding="utf-8")
    path = f"{CLOCK}{os.pathsep}{os.environ.get('PYTHONPATH', '')}"
    off = {"WALL_CLOCK": str(clock), "PYTHONPATH": path}
    host.start_master()
    host.launch(
        "robot", off if "robot" in whose else None, overrides=ROSTEST / "patient_robot.yaml"
    )
    host.launch(
        "controller",
        off if "controller" in whose else None,
        overrides=ROSTEST / "patient_controller.yaml",
        on_recording_loss="ignore",
    )
    words = (str(PROGRAMS / "clock_witness.py"), str(clock), str(results))
    witness = host.start(sys.executable, *words)
    wait_until(lambda: witness.poll() is not None, "a robot that was watched")
    said = host.said()
    assert witness.returncode == 0, said[-3000:]
    found = json.loads(results.read_text(encoding="utf-8"))
    assert len(found) == 6
    for one in found:
        assert one["state"] in ("moving", "active", "halted", "faulted"), one
        assert one["reason"] or one["state"] in ("moving", "active"), one
        assert 'say "hey robot"' in one["refused"], one
        assert one["drift"] < HELD and one["step"] < STEP and one["rcm"] < RCM, one
    jumps = {f"{one['jump']:+.1f}" for one in found}
    told = re.findall(r"the wall clock was set by (\S+) s", said)
    assert {f"{float(one):+.1f}" for one in told} == jumps
    assert any(one["state"] == "faulted" for one in found)

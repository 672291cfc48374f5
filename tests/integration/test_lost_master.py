# SPDX-License-Identifier: BSD-3-Clause
"""The ROS master dies in mid-motion and is started anew; robot and controller run all the while."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

from support.waiting import PATIENCE, wait_until
from tests.support.ros_host import ASK, ROSTEST, patient_controller

PROGRAMS = Path(__file__).parent / "programs"
LIMIT = 2 * PATIENCE  # [s] for a witness that finds everything, and leads the robot
SEEN = 7.0  # [s] for master_failover to have seen all; it reads parameters every 3 s


def test_all_brakes_is_named_and_found_again_with_the_next_master(host, tmp_path):
    first = host.start_master()
    host.launch("robot", overrides=ROSTEST / "patient_robot.yaml")
    slow = patient_controller(tmp_path)  # the motion must outlast the call that gave it
    host.launch("controller", overrides=slow, on_recording_loss="ignore")
    wait_until(lambda: host.is_found("/rst_control/command"), "a controller", every=ASK)
    wait_until(
        lambda: "accepted: True" in host.give("hey robot"), '"hey robot" accepted', every=1.0
    )
    parameters = host.parameter("/controller")
    assert "tip_speed" in str(parameters)
    time.sleep(SEEN)
    assert "accepted: True" in host.give("tense")
    os.kill(host.master.getPid(), signal.SIGKILL)
    wait_until(lambda: not host.is_there(), "the master gone")
    first.wait(PATIENCE)  # roscore ends with the master
    host.start_master()
    wait_until(
        lambda: host.is_found("/rst_control/command"), "the controller found by others", every=ASK
    )
    wait_until(lambda: host.parameter("/controller") == parameters, "the parameters", every=ASK)
    witness = host.start(
        sys.executable, str(PROGRAMS / "master_witness.py"), stdout=subprocess.PIPE, text=True
    )
    printed, _ = witness.communicate(timeout=LIMIT)
    assert witness.returncode == 0, host.said()[-3000:]
    latch = ["faulted", "the ROS master ended: nobody new could stop the robot"]
    assert json.loads(printed) == latch

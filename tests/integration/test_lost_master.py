# SPDX-License-Identifier: BSD-3-Clause
"""The ROS master dies in mid-motion and is started anew; robot and controller run all the while."""

import os
import re
import signal
import subprocess
import time

from support.waiting import PATIENCE, wait_until
from tests.support.ros_host import ASK, ROSTEST


def said(*words):
    """What a command of ROS prints, as a client that begins anew."""
    done = subprocess.run(words, capture_output=True, text=True, timeout=PATIENCE, check=False)
    return done.stdout + done.stderr


def give(command):
    return said("rosservice", "call", "/rst_control/command", f"command: '{command}'")


def state():
    """Present state and the reason of a latch."""
    text = said("rostopic", "echo", "-n", "1", "/rst_control/state")
    found = {key: re.search(rf"^{key}: (.*)$", text, re.M) for key in ("state", "halt_reason")}
    return tuple(match[1].strip("\"'") if match else "" for match in found.values())


def test_all_brakes_is_named_and_found_again_with_the_next_master(host):
    first = host.start_master()
    host.launch("robot", overrides=ROSTEST / "patient_robot.yaml")
    host.launch(
        "controller", overrides=ROSTEST / "patient_controller.yaml", on_recording_loss="ignore"
    )
    wait_until(lambda: host.is_found("/rst_control/command"), "a controller", every=ASK)
    wait_until(lambda: "accepted: True" in give("hey robot"), '"hey robot" accepted', every=1.0)
    parameters = said("rosparam", "get", "/controller")
    assert "tip_speed" in parameters
    time.sleep(2.0)  # for master_failover to have seen all
    assert "accepted: True" in give("tense")
    os.kill(host.master.getPid(), signal.SIGKILL)
    wait_until(lambda: not host.is_there(), "the master gone")
    first.wait(PATIENCE)  # roscore ends with the master
    host.start_master()
    wait_until(
        lambda: host.is_found("/rst_control/command"), "the controller found by others", every=ASK
    )
    assert state() == ("faulted", "the ROS master ended: nobody new could stop the robot")
    wait_until(
        lambda: said("rosparam", "get", "/controller") == parameters, "the parameters", every=1.0
    )
    wait_until(lambda: "accepted: True" in give("hey robot"), '"hey robot" accepted', every=1.0)
    assert state()[0] == "active"
    assert "accepted: True" in give("tense")
    assert "accepted: True" in give("stop")

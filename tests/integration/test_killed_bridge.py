# SPDX-License-Identifier: BSD-3-Clause
"""The launch of the real robot beside drivers of its own, and its bridge killed in mid-motion."""

import json
import sys
from pathlib import Path

from support.waiting import wait_until
from tests.support.ros_host import ROSTEST

PROGRAMS = Path(__file__).parent / "programs"
LIMITS = ROSTEST.parents[1] / "catkin_ws/src/rst_control/config/kinova_limits.yaml"
TROCAR = {"trocar_x": 0.406, "trocar_y": -0.024, "trocar_z": 0.415}
LEFT_OUT = dict.fromkeys(("dry_run", "voice", "alarms", "record"), "false")


def test_the_arm_is_stopped_and_the_launch_ends(host, tmp_path):
    """The driver would turn the joints on for ever; roslaunch ends the guard with the bridge."""
    host.start_master()
    host.launch(
        "robot",
        mode="kinova_strict",
        force_sensor="robot/tension_sensor",
        overrides=ROSTEST / "kinova" / "kinova_robot.yaml",
    )
    system = host.launch(
        "kinova",
        i_have_an_emergency_stop="true",
        in_air="true",
        limits=LIMITS,
        speed_scale=1.0,
        bridge_overrides=ROSTEST / "kinova" / "kinova_bridge.yaml",
        controller_overrides=ROSTEST / "kinova" / "kinova_controller.yaml",
        **TROCAR,
        **LEFT_OUT,
    )
    results = tmp_path / "seen.json"
    witness = host.start(sys.executable, str(PROGRAMS / "arm_witness.py"), str(results))
    wait_until(lambda: witness.poll() is not None, "an arm that was watched")
    said = host.said()
    assert results.is_file(), said
    found = json.loads(results.read_text(encoding="utf-8"))
    assert found["speed"] > 0.01
    assert found["stops"] > 0
    assert found["rest"] is not None and found["last_speed"] < 1e-3, found
    assert found["drift"] < 1e-3 and found["seen"] > 4.0
    wait_until(lambda: system.poll() is not None, "the launch ended")

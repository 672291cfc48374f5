# SPDX-License-Identifier: BSD-3-Clause
"""The launch of the real robot beside drivers of its own: its clocks are set, its bridge killed."""

import json
import sys
from collections import Counter
from contextlib import closing
from types import SimpleNamespace

import pytest

from support.waiting import wait_until
from tests.integration.test_clock_jumps import PROGRAMS, clock_of, witnessed
from tests.support.ros_host import ROOT, ROSTEST, Host

KINOVA = ROSTEST / "kinova"
LIMITS = ROOT / "catkin_ws/src/rst_control/config/kinova_limits.yaml"
TROCAR = {"trocar_x": 0.406, "trocar_y": -0.024, "trocar_z": 0.415}
LEFT_OUT = dict.fromkeys(("dry_run", "voice", "alarms", "record"), "false")
pytestmark = pytest.mark.timeout(600)
JUMPS = {"both": (30.0,), "robot": (30.0, -3.0)}  # [s]


@pytest.fixture(scope="module")
def arm(tmp_path_factory):
    """Host, launch, and files that set the wall clocks of the bridge and of all other nodes."""
    folder = tmp_path_factory.mktemp("arm")
    clocks = {"both": folder / "both", "robot": folder / "kinova_bridge"}
    others = folder / "others"
    variables = clock_of(clocks["both"], others, kinova_bridge=clocks["robot"])
    with closing(Host(folder)) as host:
        host.start_master()
        host.launch(
            "robot",
            variables,
            mode="kinova_strict",
            force_sensor="robot/tension_sensor",
            overrides=KINOVA / "kinova_robot.yaml",
        )
        launch = host.launch(
            "kinova",
            variables,
            i_have_an_emergency_stop="true",
            in_air="true",
            limits=LIMITS,
            speed_scale=1.0,
            bridge_overrides=KINOVA / "kinova_bridge.yaml",
            controller_overrides=KINOVA / "kinova_controller.yaml",
            **TROCAR,
            **LEFT_OUT,
        )
        yield SimpleNamespace(host=host, launch=launch, clocks=clocks)


def test_a_kinova_arm_is_led_by_the_steady_clock(arm, tmp_path):
    """The clocks of its bridge, or of all nodes, are set."""
    found, _ = witnessed(arm.host, tmp_path, JUMPS, arm.clocks)
    assert Counter(one["whose"] for one in found) == {"both": 2, "robot": 4}
    for one in found:
        assert one["drift"] < 1e-4 and one["rcm"] < 1e-3, one
    assert found[0]["whose"] == "both" and found[0]["state"] in ("moving", "active"), found[0]


def test_the_arm_is_stopped_and_the_launch_ends(arm, tmp_path):
    """The driver would turn the joints on for ever; roslaunch ends the guard with the bridge."""
    results = tmp_path / "seen.json"
    witness = arm.host.start(sys.executable, str(PROGRAMS / "arm_witness.py"), str(results))
    wait_until(lambda: witness.poll() is not None, "an arm that was watched")
    said = arm.host.said()
    assert results.is_file(), said
    found = json.loads(results.read_text(encoding="utf-8"))
    assert found["speed"] > 0.01
    assert found["stops"] > 0
    assert found["rest"] is not None and found["last_speed"] < 1e-3, found
    assert found["drift"] < 1e-3 and found["seen"] > 4.0
    wait_until(lambda: arm.launch.poll() is not None, "the launch ended")

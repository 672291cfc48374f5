# SPDX-License-Identifier: BSD-3-Clause
"""Who is started anew where it crashes, and who ends the launch."""

from pathlib import Path

import pytest

from support.waiting import PATIENCE
from tests.support.launch_reading import read
from tests.support.ros_host import Host

LAUNCH = Path(__file__).resolve().parents[2] / "launch"
KEPT = ("controller", "robot", "voice_assist")
ALWAYS = ("alarms", "master_failover", "display", "pedal", "devices", "crtk", "candidates")


@pytest.fixture(scope="module")
def nodes():
    switched_on = [f"{name}:=true" for name in ALWAYS if name not in ("alarms", "master_failover")]
    return read([str(LAUNCH / "system.launch"), *switched_on]).nodes


@pytest.mark.parametrize("name", KEPT)
def test_who_crashes_is_started_anew_and_who_ends_otherwise_ends_the_launch(nodes, name):
    node = nodes[f"/{name}"]
    assert Path(node.prefix).name == "respawn" and Path(node.prefix).is_file()
    assert node.required and not node.respawn


@pytest.mark.parametrize("name", ALWAYS)
def test_who_moves_nothing_is_always_started_anew_but_for_a_wrong_setting(nodes, name):
    node = nodes[f"/{name}"]
    program, option = node.prefix.split()
    assert (Path(program).name, option) == ("respawn", "--always")
    assert node.required and not node.respawn


def test_roslaunch_itself_starts_no_node_again_but_the_stop_guard():
    """It would do so after a wrong setting too. The guard has to outlive a roslaunch."""
    again = [f.stem for f in LAUNCH.glob("*.launch") if 'respawn="true"' in f.read_text("utf-8")]
    assert again == ["kinova_guard"]


def test_a_wrong_setting_ends_the_launch_with_one_sentence(tmp_path):
    host = Host(tmp_path)
    launch = host.start(
        *("roslaunch", "-p", str(host.port), str(LAUNCH / "display.launch"), "port:=99999")
    )
    try:
        launch.wait(PATIENCE)
    finally:
        host.close()
    words = "display cannot start: display.yaml: port is 99999, allowed: a whole number from 0 to"
    assert host.said().count(words) == 1

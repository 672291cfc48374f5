# SPDX-License-Identifier: BSD-3-Clause
"""Who is started anew where it crashes, and who ends the launch."""

from pathlib import Path

import pytest
from roslaunch.config import load_config_default

LAUNCH = Path(__file__).resolve().parents[2] / "launch"
KEPT = ("controller", "robot", "voice_assist")


def nodes(file, *arguments):
    config = load_config_default([(str(LAUNCH / file), list(arguments))], None, verbose=False)
    return {node.name: node for node in config.nodes}


@pytest.mark.parametrize("name", KEPT)
def test_who_crashes_is_started_anew_and_who_ends_otherwise_ends_the_launch(name):
    node = nodes("system.launch")[name]
    assert Path(node.launch_prefix).name == "respawn" and Path(node.launch_prefix).is_file()
    assert node.required and not node.respawn


@pytest.mark.parametrize("name", ["alarms", "master_failover"])
def test_who_moves_nothing_is_respawned(name):
    node = nodes("system.launch")[name]
    assert node.respawn and not node.required

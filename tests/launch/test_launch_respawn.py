# SPDX-License-Identifier: BSD-3-Clause
"""Who is started anew where it crashes, and who ends the launch."""

from pathlib import Path

import pytest

from tests.support.launch_reading import read

LAUNCH = Path(__file__).resolve().parents[2] / "launch"
KEPT = ("controller", "robot", "voice_assist")


@pytest.fixture(scope="module")
def nodes():
    return read([str(LAUNCH / "system.launch")]).nodes


@pytest.mark.parametrize("name", KEPT)
def test_who_crashes_is_started_anew_and_who_ends_otherwise_ends_the_launch(nodes, name):
    node = nodes[f"/{name}"]
    assert Path(node.prefix).name == "respawn" and Path(node.prefix).is_file()
    assert node.required and not node.respawn


@pytest.mark.parametrize("name", ["alarms", "master_failover"])
def test_who_moves_nothing_is_respawned(nodes, name):
    node = nodes[f"/{name}"]
    assert node.respawn and not node.required

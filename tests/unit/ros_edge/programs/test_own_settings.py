# SPDX-License-Identifier: BSD-3-Clause
"""The settings of a session in which a program presses the pedals: demo and paper."""

import pytest

from demo import theatre
from paper.play import pedal_session
from typed_config import load_yaml
from typed_config.node_names import is_allowed
from voice_assist.config import CONFIG_DIR
from voice_assist.config.believed import believed_config

COPIES = {
    "demo": lambda folder: theatre.settings(folder)["config"],
    "paper": pedal_session.own_settings,
}


@pytest.mark.parametrize("node", COPIES)
def test_the_pedals_believe_the_program_that_presses_and_nothing_else_is_changed(node, tmp_path):
    given = load_yaml(COPIES[node](tmp_path) / "believed.yaml")
    believed = believed_config(given)
    assert is_allowed(f"/{node}_25977_1795639020991", believed.joy)  # a name as rospy makes it
    assert not is_allowed("/play_1700000000", believed.joy)
    assert given == {**load_yaml(CONFIG_DIR / "believed.yaml"), "joy": list(believed.joy)}

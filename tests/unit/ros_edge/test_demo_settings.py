# SPDX-License-Identifier: BSD-3-Clause
"""The demo's own copy of the settings."""

from demo.theatre import settings
from typed_config import load_yaml
from typed_config.node_names import is_allowed
from voice_assist.config import CONFIG_DIR
from voice_assist.config.believed import believed_config


def test_the_pedals_believe_the_foot_that_the_demo_plays_and_nothing_else_is_changed(tmp_path):
    config = settings(tmp_path)["config"]
    believed = believed_config(load_yaml(config / "believed.yaml"))
    assert is_allowed("/demo_25977_1795639020991", believed.joy)  # a name as rospy makes it
    assert not is_allowed("/play_1700000000", believed.joy)
    shipped = load_yaml(CONFIG_DIR / "believed.yaml")
    assert load_yaml(config / "believed.yaml") == {**shipped, "joy": list(believed.joy)}

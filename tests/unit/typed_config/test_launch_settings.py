# SPDX-License-Identifier: BSD-3-Clause
"""A node that is started anew has the settings of its launch, whatever was changed since."""

import pytest

from typed_config import ConfigError
from typed_config.ros import launch_settings as module
from typed_config.ros.launch_settings import differences, launch_settings


@pytest.fixture
def server(monkeypatch):
    """The private parameters of the node, and what is logged."""
    parameters, said = {"tension": {"limit": 2.4}, "rate": 500.0}, []
    monkeypatch.setattr(module.rospy, "get_param", lambda name, default: parameters)
    monkeypatch.setattr(
        module.rospy, "set_param", lambda name, value: parameters.update({name[1:]: value})
    )
    monkeypatch.setattr(module.rospy, "logerr", lambda words, *more: said.append(words % more))
    return parameters, said


def test_the_first_start_takes_and_keeps_what_is_there(server):
    parameters, said = server
    assert launch_settings() == {"tension": {"limit": 2.4}, "rate": 500.0}
    assert "launched" in parameters and not said


def test_a_later_start_takes_those_and_names_what_was_changed(server):
    parameters, said = server
    first = launch_settings()
    parameters["tension"] = {"limit": 24.0}
    parameters["new"] = 1
    del parameters["rate"]
    assert launch_settings() == first
    assert len(said) == 3
    assert any("tension/limit is 24.0, at the launch 2.4" in words for words in said)


def test_what_the_node_sets_itself_is_taken_as_it_is(server):
    parameters, said = server
    launch_settings(own=("rate",))
    parameters["rate"] = 250.0
    assert launch_settings(own=("rate",)) == {"tension": {"limit": 2.4}, "rate": 250.0}
    assert not said


def test_a_first_start_that_is_known_to_be_one_keeps_anew(server):
    parameters, said = server
    launch_settings()
    parameters["rate"] = 250.0
    assert launch_settings(is_first=True)["rate"] == 250.0
    assert launch_settings()["rate"] == 250.0 and not said


def test_after_a_crash_settings_that_nobody_kept_are_refused(server, monkeypatch):
    monkeypatch.setenv(module.RESTART, "1")
    with pytest.raises(ConfigError, match="launched is None, allowed: the settings of the launch"):
        launch_settings()


def test_equal_settings_differ_in_nothing():
    assert differences({"a": {"b": [1, 2]}}, {"a": {"b": [1, 2]}}) == []

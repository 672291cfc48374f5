# SPDX-License-Identifier: BSD-3-Clause
"""A node that is started anew has the settings of its launch, whatever was changed since."""

from __future__ import annotations

import pytest

from rst_control.ros.common import launch_settings as module
from rst_control.ros.common.launch_settings import differences, launch_settings


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


def test_equal_settings_differ_in_nothing():
    assert differences({"a": {"b": [1, 2]}}, {"a": {"b": [1, 2]}}) == []

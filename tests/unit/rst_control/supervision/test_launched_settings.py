# SPDX-License-Identifier: BSD-3-Clause
"""Settings on the server that are not those of the launch are named, and once as news."""

import pytest

from rst_control.supervision.launched_settings import LaunchedSettings
from typed_config.ros.launch_settings import differences

LAUNCHED = {"tension": {"limit": 2.4}, "rate": 500.0}
EDITED = {"tension": {"limit": 24.0}, "rate": 500.0}
WORDS = "controller: tension/limit is 24.0, at the launch 2.4"


@pytest.fixture
def settings():
    one = LaunchedSettings(differences)
    assert one.update({"controller": (LAUNCHED, LAUNCHED), "robot": (LAUNCHED, LAUNCHED)}) == ""
    return one


def robot_and(kept, now):
    return {"controller": (kept, now), "robot": (LAUNCHED, LAUNCHED)}


def test_an_edited_setting_is_news_once_and_a_problem_until_it_is_put_back(settings):
    assert settings.update(robot_and(LAUNCHED, EDITED)) == WORDS
    assert settings.update(robot_and(LAUNCHED, EDITED)) == ""
    assert settings.problem == WORDS
    assert settings.update(robot_and(LAUNCHED, LAUNCHED)) == ""
    assert settings.problem == ""
    assert settings.update(robot_and(LAUNCHED, EDITED)) == WORDS


def test_what_a_node_adds_itself_is_none(settings):
    assert settings.update(robot_and(LAUNCHED, {**LAUNCHED, "page": "http://host"})) == ""


def test_a_node_that_was_launched_anew_with_others_is_named_and_then_has_these(settings):
    words = "controller was launched anew, with other settings: tension/limit is 24.0, at the"
    assert settings.update(robot_and(EDITED, EDITED)).startswith(words)
    assert settings.update(robot_and(EDITED, EDITED)) == ""
    assert settings.problem == ""


def test_a_node_that_was_launched_anew_with_the_same_is_none(settings):
    assert settings.update(robot_and(dict(LAUNCHED), dict(LAUNCHED))) == ""


def test_settings_that_are_gone_are_named(settings):
    assert "those of its launch are gone" in settings.update(robot_and(None, LAUNCHED))
    assert settings.update({"robot": (LAUNCHED, LAUNCHED)}) == "controller: all are gone"


def test_what_is_no_node_that_keeps_settings_is_none(settings):
    with_others = {**robot_and(LAUNCHED, LAUNCHED), "session": (None, {"seed": 1})}
    assert settings.update(with_others) == ""


def test_of_many_differences_the_first_are_named_and_all_are_counted(settings):
    many = {f"key{number}": number for number in range(9)}
    one = LaunchedSettings(differences)
    one.update({"a": (many, many)})
    assert one.update({"a": (many, dict.fromkeys(many, 100))}).endswith("; and 6 more")

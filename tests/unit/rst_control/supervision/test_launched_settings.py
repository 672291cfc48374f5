# SPDX-License-Identifier: BSD-3-Clause
"""Settings on the server that are not those of the launch are named, and once as news."""

import pytest

from rst_control.supervision.launched_settings import GONE_LOOKS, LaunchedSettings
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


def updates(settings, nodes, count):
    return [settings.update(nodes) for _ in range(count)]


ALONE = {"robot": (LAUNCHED, LAUNCHED)}  # while the controller has no settings at all


def test_a_node_that_is_launched_again_with_the_same_is_none_however_long_it_starts(settings):
    assert settings.update(ALONE) == ""  # cleared, and not set yet
    partly = {"tension": {}, "rate": 500.0}
    assert settings.update(robot_and(None, partly)) == ""
    assert set(updates(settings, robot_and(None, LAUNCHED), 5 * GONE_LOOKS)) == {""}
    assert settings.problem == ""
    assert settings.update(robot_and(LAUNCHED, LAUNCHED)) == ""


@pytest.mark.parametrize("now", [EDITED, {"tension": {"limit": 24.0}}])
def test_other_settings_are_named_at_once_where_a_node_keeps_none(settings, now):
    assert settings.update(robot_and(None, now)) == WORDS
    assert settings.update(robot_and(None, now)) == ""
    assert settings.problem == WORDS


@pytest.mark.parametrize(
    ("nodes", "words"),
    [
        (ALONE, "controller: all are gone"),
        (robot_and(None, {}), "controller: all are gone"),
        (robot_and(None, {"page": "http://host"}), "controller: all are gone"),
        (
            robot_and(None, {"rate": 500.0, "tension": {}}),
            "controller: tension/limit is None, at the launch 2.4",
        ),
    ],
)
def test_settings_that_stay_gone_are_named_once(settings, nodes, words):
    assert updates(settings, nodes, GONE_LOOKS + 1) == [""] * (GONE_LOOKS - 1) + [words, ""]
    assert settings.problem == words


def test_settings_that_were_gone_for_a_moment_again_and_again_are_none(settings):
    for _ in range(3):
        assert set(updates(settings, ALONE, GONE_LOOKS - 1)) == {""}
        assert settings.update(robot_and(LAUNCHED, LAUNCHED)) == ""


def test_what_is_no_node_that_keeps_settings_is_none(settings):
    with_others = {**robot_and(LAUNCHED, LAUNCHED), "session": (None, {"seed": 1})}
    assert settings.update(with_others) == ""


def test_of_many_differences_the_first_are_named_and_all_are_counted(settings):
    many = {f"key{number}": number for number in range(9)}
    one = LaunchedSettings(differences)
    one.update({"a": (many, many)})
    assert one.update({"a": (many, dict.fromkeys(many, 100))}).endswith("; and 6 more")

# SPDX-License-Identifier: BSD-3-Clause
"""What the controller calls each phrase, by what the recorder writes of the voice node."""

import pytest
import yaml

from session_log.mcap_file.condition import FileCondition
from session_log.recording.metadata import parameter_facts
from session_log.report.session.controller_words import controller_words
from typed_config import load_yaml, package_folder


def recorded(*trees):
    """The condition of a recording with these parameters, one after the other."""
    return FileCondition(metadata=[("parameters", parameter_facts(tree)) for tree in trees])


def commands(*listed):
    return {"commands": {"language": "de", "commands": list(listed)}}


@pytest.mark.parametrize("language", ["de", "es", "fr", "ja"])
def test_all_stop_phrases_of_a_language_are_the_controllers_stop(language):
    path = package_folder("voice_assist") / "config" / f"commands_{language}.yaml"
    settings = load_yaml(path)
    condition = recorded({"voice_assist": {"commands": settings}})
    found = controller_words(condition, ["/voice_assist"])
    halts = [c["phrase"] for c in settings["commands"] if c["is_halt"]]
    assert len(halts) >= 2 and {found[phrase] for phrase in halts} == {"stop"}
    assert "tense" in found.values()


def test_a_halt_of_its_own_is_a_stop_and_what_calls_nothing_has_its_own_name():
    listed = commands(
        {"phrase": "freeze", "command": "", "is_halt": True},
        {"phrase": "light on", "command": "", "is_halt": False},
        {"phrase": "go tight", "command": "tense"},
    )
    found = controller_words(recorded({"voice_assist": listed}), ["/voice_assist"])
    assert found == {"freeze": "stop", "light on": "light on", "go tight": "tense"}


def test_words_of_all_runs_of_the_node_are_known_the_last_ones_first():
    runs = (
        commands({"phrase": "halt", "command": "stop"}, {"phrase": "a", "command": "tense"}),
        commands({"phrase": "a", "command": "release"}),
    )
    condition = recorded(*({"voice_assist": run} for run in runs))
    assert controller_words(condition, ["/voice_assist"]) == {"halt": "stop", "a": "release"}


def test_a_node_that_was_recorded_from_outside_of_its_namespace_has_its_own():
    trees = {"left": {"voice_assist": commands({"phrase": "halt", "command": "stop"})}}
    assert controller_words(recorded(trees), ["/left/voice_assist"]) == {"halt": "stop"}
    assert controller_words(recorded(trees), ["/voice_assist", ""]) == {}


@pytest.mark.parametrize(
    "text",
    [
        "",
        "commands: {commands: 3}",
        "commands: [",
        yaml.safe_dump(commands("stop", {"phrase": "halt", "call": "stop"}, {"command": "stop"})),
    ],
)
def test_what_older_or_odd_settings_do_not_say_is_not_known(text):
    condition = FileCondition(metadata=[("parameters", {"voice_assist": text})])
    assert controller_words(condition, ["/voice_assist"]) == {}

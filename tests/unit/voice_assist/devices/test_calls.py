# SPDX-License-Identifier: BSD-3-Clause
"""Which calls follow words and stops; and which settings are no harmless calls."""

from itertools import islice

import pytest

from typed_config import ConfigError, load_config, load_yaml
from voice_assist.config import CONFIG_DIR, CommandsConfig
from voice_assist.config.devices import devices_config, require_harmless
from voice_assist.devices.calls import MAX_WAITING, CallResult, DeviceCalls, result_words

FILE = load_yaml(CONFIG_DIR / "devices.yaml")
COMMANDS = load_config(CommandsConfig, load_yaml(CONFIG_DIR / "theatre_commands.yaml"))


def call(phrase="light on", **changes):
    made = {
        "phrase": phrase,
        "kind": "service",
        "target": "/theatre/light",
        "type": "std_srvs/SetBool",
        "arguments": "{data: true}",
        "within": 2.0,
        "on_stop": "",
    }
    return {**made, **changes}


def made(*calls):
    return devices_config({"calls": list(calls)})


def end(calls, one, is_done=True, may_have_effect=True):
    """A call that was given ends."""
    calls.ended(CallResult(one, is_done, "", may_have_effect))


def begun(calls, count=100):
    """Phrases of the calls that are begun now and do not end, in their order."""
    return [one.phrase for one in islice(iter(lambda: calls.next(0.0), None), count)]


def undone(calls, is_done=True):
    """Phrases of the calls that a stop's thread makes now, in their order."""
    phrases = []
    while (one := calls.next_undoing(0.0)) is not None:
        phrases.append(one.phrase)
        end(calls, one, is_done)
    return phrases


def make(calls, *words, **result):
    for word in words:
        assert calls.said(word) is None
        one = calls.next(0.0)
        assert one.phrase == word
        end(calls, one, **result)


PRESSURE = (call("higher pressure", on_stop="pressure down"), call("pressure down"))
LIGHT = (call("light on", on_stop="go dark"), call("go dark"))


def test_a_result_is_worded_alike_aloud_and_on_the_page():
    assert result_words("light on", True, "") == "light on: done"
    assert result_words("light on", False, "no answer") == "light on: failed, no answer"


def test_the_examples_calls_are_harmless():
    require_harmless(devices_config(FILE), COMMANDS)


def test_a_word_makes_its_call_and_no_other_word_makes_one():
    calls = DeviceCalls(devices_config(FILE))
    assert calls.said("light on") is None
    assert calls.next(0.0).values == {"data": True}
    for word in ("stop", "tense", "light", "", "raise"):
        assert calls.said(word) is None
        assert calls.next(0.0) is None


def test_too_many_calls_are_refused_by_number():
    calls = DeviceCalls(made(*LIGHT))
    refused = [calls.said("light on") for _ in range(MAX_WAITING + 1)]
    assert refused[:-1] == [None] * MAX_WAITING
    assert (refused[-1].is_done, refused[-1].words) == (False, "5 calls wait already, allowed: 5")
    assert begun(calls) == ["light on"] * MAX_WAITING


def test_a_stop_undoes_what_says_so_once_the_newest_first():
    calls = DeviceCalls(made(*PRESSURE, *LIGHT))
    assert calls.stopped() == ()
    make(calls, "higher pressure", "higher pressure", "light on")
    assert calls.stopped() == ()
    assert undone(calls) == ["go dark", "pressure down"]
    assert calls.stopped() == ()
    assert undone(calls) == begun(calls) == []


def test_a_stop_that_is_reported_twice_undoes_all_of_it_once():
    calls = DeviceCalls(made(*PRESSURE, *LIGHT))
    make(calls, "higher pressure", "light on")
    calls.stopped()
    dark = calls.next_undoing(0.0)
    assert dark.phrase == "go dark"
    assert calls.stopped() == ()  # the stop topic first, then the controller's event
    end(calls, dark)
    assert calls.stopped() == ()
    assert undone(calls) == ["pressure down"]


@pytest.mark.parametrize("before", [(), ("higher pressure",)])
@pytest.mark.parametrize("may_have_effect", [False, True])
def test_a_call_that_failed_is_undone_only_if_it_may_have_had_an_effect(before, may_have_effect):
    """An earlier one that was done is undone in any case."""
    calls = DeviceCalls(made(*PRESSURE))
    make(calls, *before)
    make(calls, "higher pressure", is_done=False, may_have_effect=may_have_effect)
    calls.stopped()
    assert undone(calls) == (["pressure down"] if before or may_have_effect else [])


def test_what_undoes_a_call_is_made_at_each_stop_until_it_is_done():
    calls = DeviceCalls(made(*LIGHT))
    make(calls, "light on")
    for is_done in (False, False, True):
        calls.stopped()
        assert undone(calls, is_done) == ["go dark"]
    calls.stopped()
    assert undone(calls) == []


def restarted():
    """Calls of a node that was started again; what its restart has to undo."""
    calls = DeviceCalls(made(*PRESSURE, *LIGHT))
    calls.undo(["higher pressure", "light on"])
    return calls


def test_what_a_restart_undoes_is_tried_again_once_after_a_pause():
    calls = restarted()
    for _ in range(2):
        assert undone(calls, is_done=False) == ["go dark", "pressure down"]
    for _ in range(2):
        assert undone(calls) == []
    calls.stopped()
    assert undone(calls, is_done=False) == ["go dark", "pressure down"]


def test_what_a_restart_undid_is_not_tried_again():
    calls = restarted()
    for undos in (["go dark", "pressure down"], [], []):
        assert undone(calls) == undos


def test_no_call_is_made_before_what_a_restart_undoes_was_tried_again():
    calls = restarted()
    calls.said("light on")
    for is_done in (False, True):
        assert calls.next(0.0) is None
        end(calls, calls.next_undoing(0.0), is_done)
    assert calls.next_undoing(0.0) is None and calls.next(0.0) is None  # the pause
    assert undone(calls) == ["go dark"]
    assert begun(calls) == ["light on"]


def test_a_stop_takes_the_place_of_what_would_be_tried_again():
    calls = restarted()
    for _ in range(2):
        end(calls, calls.next_undoing(0.0), is_done=False)
    calls.stopped()
    for undos in (["go dark", "pressure down"], [], []):
        assert undone(calls) == undos


NO_ANSWER = {"is_done": False, "may_have_effect": True}
REFUSED = {"is_done": False, "may_have_effect": False}


@pytest.mark.parametrize(
    ("result", "again"), [({}, ["go dark"]), (NO_ANSWER, ["go dark"]), (REFUSED, [])]
)
def test_a_call_at_work_is_undone_once_and_again_when_it_ends_after_that(result, again):
    calls = DeviceCalls(made(*LIGHT))
    calls.said("light on")
    light = calls.next(0.0)
    for undos in (["go dark"], []):  # one stop, reported twice
        calls.stopped()
        assert undone(calls) == undos
    end(calls, light, **result)
    assert undone(calls) == again
    calls.stopped()
    assert undone(calls) == []


def test_a_call_that_ends_while_what_undoes_it_is_at_work_is_undone_again():
    """Nobody knows which of the two took effect last."""
    calls = DeviceCalls(made(*LIGHT))
    calls.said("light on")
    light = calls.next(0.0)
    calls.stopped()
    dark = calls.next_undoing(0.0)
    end(calls, light)
    end(calls, dark)
    assert undone(calls, is_done=False) == ["go dark"]
    calls.stopped()
    assert undone(calls) == ["go dark"]
    calls.stopped()
    assert undone(calls) == []


def test_what_fails_when_it_undoes_a_late_call_is_made_at_the_next_stop():
    calls = DeviceCalls(made(*LIGHT))
    calls.said("light on")
    light = calls.next(0.0)
    calls.stopped()
    undone(calls)
    end(calls, light)
    for is_done in (False, True):
        assert undone(calls, is_done) == ["go dark"]
        calls.stopped()
    assert undone(calls) == []


def test_the_next_call_waits_until_a_late_one_is_undone():
    calls = DeviceCalls(made(*LIGHT))
    calls.said("light on")
    light = calls.next(0.0)
    calls.stopped()
    undone(calls)
    calls.said("light on")
    end(calls, light)
    assert begun(calls) == []
    assert undone(calls) == ["go dark"]
    assert begun(calls) == ["light on"]


def test_what_waits_at_a_stop_is_dropped_and_not_undone():
    calls = DeviceCalls(made(*PRESSURE, *LIGHT))
    calls.said("higher pressure")
    (dropped,) = calls.stopped()
    assert (dropped.call.phrase, dropped.is_done) == ("higher pressure", False)
    assert undone(calls) == begun(calls) == []


def test_a_stop_undoes_what_was_about_to_be_undone_by_a_word():
    calls = DeviceCalls(made(*LIGHT))
    make(calls, "light on")
    calls.said("go dark")
    assert calls.stopped() == ()
    assert undone(calls) == ["go dark"]


def test_what_was_undone_by_a_word_is_not_undone_again():
    calls = DeviceCalls(made(*LIGHT))
    make(calls, "light on", "go dark")
    assert calls.stopped() == ()
    assert undone(calls) == begun(calls) == []


def test_what_is_said_after_a_stop_waits_for_what_the_stop_undoes():
    calls = DeviceCalls(made(*LIGHT))
    make(calls, "light on")
    calls.stopped()
    calls.said("light on")
    assert begun(calls) == []
    dark = calls.next_undoing(0.0)
    assert dark.phrase == "go dark"
    assert begun(calls) == []  # it is at work
    end(calls, dark)
    assert undone(calls) == []
    assert begun(calls) == ["light on"]


def test_what_a_stop_has_to_undo_is_known_also_while_it_is_at_work_and_until_it_is_undone():
    calls = DeviceCalls(made(*PRESSURE, *LIGHT))
    make(calls, "light on", **REFUSED)
    assert calls.to_undo() == []
    make(calls, "higher pressure")
    calls.said("light on")
    assert begun(calls) == ["light on"]
    assert calls.to_undo() == ["higher pressure", "light on"]
    calls.stopped()
    assert undone(calls, is_done=False) == ["go dark", "pressure down"]
    assert calls.to_undo() == ["higher pressure", "light on"]
    calls.stopped()
    assert undone(calls) == ["go dark", "pressure down"]
    assert calls.to_undo() == []


def test_what_an_earlier_process_had_to_undo_is_undone_at_once_and_until_it_is_done():
    calls = DeviceCalls(made(*PRESSURE, *LIGHT))
    calls.undo(["higher pressure", "light on", "go dark", "no phrase any more"])
    assert undone(calls, is_done=False) == ["go dark", "pressure down"]
    calls.stopped()
    assert undone(calls) == ["go dark", "pressure down"]
    calls.stopped()
    assert undone(calls) == []


def test_a_stop_concerns_the_call_at_work_unless_that_undoes_another():
    calls = DeviceCalls(made(*LIGHT))
    for phrase, is_given_up in (("light on", True), ("go dark", False)):
        calls.said(phrase)
        assert begun(calls) == [phrase]
        is_stopped = calls.stop_check(made(*LIGHT).get(phrase))
        assert not is_stopped()
        calls.stopped()
        assert is_stopped() is is_given_up
        undone(calls)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"target": "/rst_control/command"}, "the robot's or this system's own"),
        ({"target": "robot/home_tool"}, "the robot's or this system's own"),
        ({"target": "/left/rst_control/set_trocar"}, "the robot's or this system's own"),
        ({"target": "/my_gen3/base/send_joint_speeds"}, "own"),
        ({"target": "/openrst/effort_controller/command"}, "own"),
        ({"target": "/left/gen3/state_command"}, "own"),
        ({"target": "voice_assist/set_microphone"}, "own"),
        ({"target": "/theatre light"}, "a name of ROS"),
        ({"target": "http://theatre"}, "a name of ROS"),
        ({"type": "SetBool"}, "a type of ROS"),
        ({"type": "std_srvs.srv/os"}, "a type of ROS"),
        ({"arguments": "[1, 2]"}, "YAML of a mapping"),
        ({"arguments": "{data: "}, "YAML of a mapping"),
        ({"arguments": "!!python/object/apply:os.system [ls]"}, "YAML of a mapping"),
        ({"within": 0.0}, "within"),
        ({"kind": "shell"}, "action"),
        ({"on_stop": "light on"}, "another phrase"),
        ({"on_stop": "go dark"}, "one of the phrases"),
    ],
)
def test_a_call_that_makes_no_sense_is_refused(changes, words):
    with pytest.raises(ConfigError, match=words):
        made(call(**changes))


def test_a_phrase_has_one_call():
    with pytest.raises(ConfigError, match="a phrase given once"):
        made(call(), call())


@pytest.mark.parametrize("phrase", ["tense", "pull more", "stop", "hey robot", "terminate"])
def test_what_moves_or_stops_the_robot_is_no_device(phrase):
    with pytest.raises(ConfigError, match="is_motion false"):
        require_harmless(made(call(phrase)), COMMANDS)


def test_a_phrase_that_cannot_be_said_is_refused():
    with pytest.raises(ConfigError, match=r"a phrase of commands\.yaml"):
        require_harmless(made(call("open the door")), COMMANDS)

# SPDX-License-Identifier: BSD-3-Clause
"""The page outlives the master and a controller that hangs; only a taken address ends it."""

import asyncio
import json
import socket
import threading
import time
from contextlib import nullcontext
from copy import deepcopy
from types import SimpleNamespace
from xml.parsers.expat import ExpatError

import pytest
import rospy

from rst_control.msg import ControllerState
from tests.unit.ros_edge.test_caller import Service
from tests.unit.voice_assist.display.support.theatre import STOPPED, Clock
from typed_config import load_file, load_yaml
from typed_config.ros import xmlrpc
from typed_config.ros.service_calls import Reply
from voice_assist.config import CONFIG_DIR
from voice_assist.config.display import FILE, DisplayConfig
from voice_assist.display.theatre import Limits, Theatre
from voice_assist.msg import Utterance
from voice_assist.ros.alarms.alarm_watch import AlarmWatch
from voice_assist.ros.display import acts as acts_module
from voice_assist.ros.display import node as node_module
from voice_assist.ros.display.acts import RosActs
from voice_assist.ros.display.node import DisplayNode, NotServedError

CONFIG = load_file(DisplayConfig, FILE)
GIVEN = {
    "/controller/controller/tension/limit": 2.4,
    "/controller/rcm/measured_tolerance": 0.001,
    "/voice_assist/recognizer/ask/answer_within": 3,
    "/voice_assist/commands": load_yaml(CONFIG_DIR / "commands.yaml"),
}


@pytest.fixture
def node():
    node = object.__new__(DisplayNode)
    node._theatre = Theatre(0.5, time.monotonic, time.time)
    node._commands = None
    node.known = SimpleNamespace(publish_status=lambda: None)
    node.clock = Clock()
    node._alarms = AlarmWatch(node._theatre.see_alarm, lambda: True, node.clock)
    return node


def answer(monkeypatch, given, errors=()):
    """In place of the master: these parameters, after these errors."""
    errors = iter(errors)

    def ask_master(method, name):
        assert method == "getParam"
        if (error := next(errors, None)) is not None:
            raise error
        if name not in given:
            raise ValueError(f"Parameter [{name}] is not set")
        return deepcopy(given[name])

    monkeypatch.setattr(xmlrpc, "ask_master", ask_master)


class From:
    """A message of a node, with what it says."""

    def __init__(self, node, **fields):
        self._connection_header = {"callerid": node}
        vars(self).update(fields)


def test_an_alarm_counts_while_the_node_that_said_it_publishes_diagnostics(monkeypatch, node):
    monkeypatch.setattr(node_module.messages, "alarm_part", lambda message: STOPPED)
    monkeypatch.setattr(node, "_look_at_settings", lambda: None)
    node._on_alarm(From("/alarms"))
    for name, shown in (("/alarms", STOPPED), ("/recorder", None)):
        for _ in range(5):
            node.clock.now += 1.0
            node._on_diagnostics(From(name, status=[]))
            node.look_again()
        assert node._theatre.snapshot().alarm == shown


@pytest.mark.parametrize("error", [ConnectionRefusedError(), TimeoutError(), ExpatError()])
def test_while_the_master_is_gone_what_was_read_stays(monkeypatch, node, error):
    answer(monkeypatch, GIVEN)
    node.look_again()
    limits, rules = node._theatre.limits, node._theatre.rules
    assert limits == Limits(2.4, 0.001) and rules
    answer(monkeypatch, {}, [error])
    node.look_again()
    assert (node._theatre.limits, node._theatre.rules) == (limits, rules)
    assert node._theatre.answer_within == 3.0


def test_a_master_that_is_back_is_read_again(monkeypatch, node):
    answer(monkeypatch, GIVEN, [ConnectionRefusedError()])
    node.look_again()
    assert node._theatre.limits == Limits()
    node.look_again()
    assert node._theatre.limits == Limits(2.4, 0.001)


def test_a_master_that_hangs_does_not_end_the_watch_over_the_alarm_node(monkeypatch, node):
    monkeypatch.setattr(xmlrpc, "ANSWER_TIME", 0.05)
    with socket.create_server(("127.0.0.1", 0)) as master:  # takes connections, answers none
        port = master.getsockname()[1]
        monkeypatch.setenv("ROS_MASTER_URI", f"http://127.0.0.1:{port}")
        looking = threading.Thread(target=node.look_again, daemon=True)
        looking.start()
        looking.join(10.0)
        assert not looking.is_alive()


def test_the_words_that_can_be_said_are_those_of_the_voice_node_launched_last(monkeypatch, node):
    answer(monkeypatch, GIVEN)
    node.look_again()
    first = node._theatre.rules
    node.look_again()
    assert node._theatre.rules is first  # built once
    german = load_yaml(CONFIG_DIR / "commands_de.yaml")
    answer(monkeypatch, {**GIVEN, "/voice_assist/commands": german})
    node.look_again()
    assert "hallo roboter" in {rule.phrase for rule in node._theatre.rules}
    answer(monkeypatch, {})
    node.look_again()
    assert node._theatre.rules == () and node._theatre.limits == Limits()


LAUNCHED = {"controller": {"tension": {"limit": 2.4}}, "rcm": {"measured_tolerance": 0.001}}


@pytest.mark.parametrize(
    ("kept", "limits"),
    [
        ({"/controller/launched": json.dumps(LAUNCHED)}, Limits(2.4, 0.001)),
        ({"/controller/launched": "{}"}, Limits()),
        ({"/controller/launched": "no settings"}, Limits(4.0, 0.002)),
        ({}, Limits(4.0, 0.002)),  # it has not started yet
    ],
)
def test_the_limits_are_those_the_controller_was_launched_with(monkeypatch, node, kept, limits):
    changed = {
        "/controller/controller/tension/limit": 4.0,
        "/controller/rcm/measured_tolerance": 0.002,
    }
    answer(monkeypatch, {**GIVEN, **changed, **kept})
    node.look_again()
    assert node._theatre.limits == limits


def test_words_and_the_time_for_an_answer_are_those_the_voice_was_launched_with(monkeypatch, node):
    ask = {"ask": {"answer_within": 3}}
    launched = {"recognizer": ask, "commands": GIVEN["/voice_assist/commands"]}
    changed = {
        "/voice_assist/recognizer/ask/answer_within": 9,
        "/voice_assist/commands": load_yaml(CONFIG_DIR / "commands_de.yaml"),
    }
    kept = {"/voice_assist/launched": json.dumps(launched)}
    answer(monkeypatch, {**GIVEN, **changed, **kept})
    node.look_again()
    assert node._theatre.answer_within == 3.0
    phrases = {rule.phrase for rule in node._theatre.rules}
    assert "hey robot" in phrases and "hallo roboter" not in phrases


def test_a_display_that_starts_late_says_how_long_has_been_recorded(node):
    node._on_file(SimpleNamespace(data="/sessions/a/session.mcap"))
    values = {"file": "/sessions/a/session.mcap", "recorded for [s]": "3725.0"}
    pairs = [SimpleNamespace(key=key, value=value) for key, value in values.items()]
    node._theatre.see_recording("")
    node._on_health(SimpleNamespace(values=pairs))
    assert node._theatre.snapshot().recording.since == pytest.approx(3725.0, abs=60.0)


@pytest.mark.parametrize("words", ["tension.source is none", ""])
def test_the_controllers_diagnostics_say_whether_the_tension_counts(node, words):
    node._on_state(ControllerState(state="moving"))
    for value in ("another", words):
        pair = SimpleNamespace(key="tension not trusted", value=value)
        node._on_health(SimpleNamespace(values=[pair]))
    node._on_health(SimpleNamespace(values=[]))  # of another part: it says nothing of the tension
    assert node._theatre.snapshot().tissue.invalid_reason == words


@pytest.mark.parametrize(("later", "age"), [(5.0, 1.0), (5.02, 0.0)])
def test_a_state_of_a_loop_that_hangs_gets_old(node, later, age):
    node._theatre = Theatre(0.5, node.clock, node.clock)
    for stamp in (5.0, later):
        node.clock.now += 1.0
        message = ControllerState(state="moving")
        message.header.stamp = rospy.Time.from_sec(stamp)
        node._on_state(message)
    assert node._theatre.snapshot().robot.age == age


class Server:
    """In place of the server: its start may fail."""

    address, viewers = "http://127.0.0.1:1", ()

    def __init__(self, *_):
        self.error = None

    async def __aenter__(self):
        raise OSError("Address already in use")

    async def __aexit__(self, *_):
        pass


class StartedServer(Server):
    async def __aenter__(self):
        return self


def served(monkeypatch, server):
    """Serve with a node whose look at the system fails."""

    def fail():
        raise ConnectionRefusedError("later")

    known = SimpleNamespace(known=None, look_again=fail)
    for name in ("Endoscope", "RosActs", "Pictures"):
        monkeypatch.setattr(node_module, name, lambda *_: None)
    monkeypatch.setattr(node_module, "DisplayNode", lambda _: known)
    monkeypatch.setattr(node_module, "DisplayServer", server)
    for name in ("set_param", "loginfo"):
        monkeypatch.setattr(rospy, name, lambda *_: None)
    monkeypatch.setattr(rospy, "is_shutdown", lambda: False)
    asyncio.run(node_module.serve(CONFIG))


def test_only_the_start_of_the_server_says_that_the_page_cannot_be_served(monkeypatch):
    with pytest.raises(NotServedError, match="the page cannot be served: Address already in use"):
        served(monkeypatch, Server)
    with pytest.raises(ConnectionRefusedError, match="later"):
        served(monkeypatch, StartedServer)


@pytest.mark.parametrize(
    ("error", "ends"), [(NotServedError("no address"), SystemExit), (OSError("later"), OSError)]
)
def test_only_an_address_that_cannot_be_had_ends_the_node_for_good(
    monkeypatch, logged, error, ends
):
    async def serve(config):
        raise error

    monkeypatch.setattr(node_module, "serve", serve)
    monkeypatch.setattr(node_module, "starting", lambda *_, **__: nullcontext())
    monkeypatch.setattr(node_module, "private_settings", lambda *_: CONFIG)
    monkeypatch.setattr(node_module, "set_priority", lambda nice: nice)
    monkeypatch.setattr(rospy, "get_param", lambda name, default: default)
    with pytest.raises(ends) as ended:
        node_module.main()
    assert getattr(ended.value, "code", None) == (2 if ends is SystemExit else None)
    assert logged == (["no address"] if ends is SystemExit else [])


@pytest.fixture
def acts(monkeypatch):
    monkeypatch.setattr(acts_module, "WITHIN", 0.05)
    monkeypatch.setattr(rospy, "Publisher", lambda *_, **__: None)
    monkeypatch.setattr(rospy, "wait_for_service", lambda name, within: None)
    return RosActs(Theatre(0.5, time.monotonic, time.time), None)


def test_a_service_that_hangs_is_given_up_in_time_and_not_asked_later(monkeypatch, acts):
    service = Service(monkeypatch, hangs="before")
    began = time.monotonic()
    outcome = acts.stop()
    assert time.monotonic() - began < 10.0
    assert (outcome.is_done, outcome.words) == (False, "the controller does not answer")
    assert service.closed == 1
    service.thaws.set()
    assert "too late" in str(service.outcomes.get(timeout=10.0))


def test_who_is_asked_has_the_same_time_but_for_a_microphone_that_may_have_to_be_searched_for(
    monkeypatch, acts
):
    asked = []

    def call(name, kind, *words, within, appears):
        asked.append((words, within, appears))
        return Reply(SimpleNamespace(accepted=True, success=True, message="so"))

    monkeypatch.setattr(acts_module, "call_service", call)
    assert acts.stop().is_done and acts.choose_microphone("usb").is_done
    within, longer = acts_module.WITHIN, acts_module.CHOICE_WITHIN
    assert asked == [(("stop",), within, within), (("usb",), longer, within)]
    assert longer > 2.5  # [s] of the others


@pytest.mark.parametrize("is_taken", [True, False])
def test_a_question_stays_on_the_page_until_an_answer_is_taken(monkeypatch, acts, is_taken):
    ended = []
    monkeypatch.setattr(acts._theatre, "end_question", lambda: ended.append(1))
    reply = Reply(SimpleNamespace(success=is_taken, message="so"))
    monkeypatch.setattr(acts_module, "_call", lambda *_, **__: reply)
    outcome = acts.answer("pull more", True)
    assert (outcome.is_done, bool(ended)) == (is_taken, is_taken)


@pytest.mark.parametrize(
    ("act", "words", "unsent"),
    [
        (lambda acts: acts.stop(), "the controller does not answer", None),
        (lambda acts: acts.answer("pull", True), "the voice node does not answer", None),
        (lambda acts: acts.set_grasp_point(0, 0, 0), "the controller does not answer", None),
        (
            lambda acts: acts.choose_microphone("usb"),
            "the voice node does not answer",
            "no voice node listens to a microphone",
        ),
    ],
)
def test_what_went_out_without_an_answer_may_still_be_taken(monkeypatch, acts, act, words, unsent):
    acts._endoscope = SimpleNamespace(point=lambda *_: (0.0, 0.0, 0.0))
    for is_sent, said in ((True, f"{words}; it may still be taken"), (False, unsent or words)):
        reply = Reply(None, "", is_sent)
        monkeypatch.setattr(acts_module, "call_service", lambda *_, reply=reply, **__: reply)
        outcome = act(acts)
        assert (outcome.is_done, outcome.words) == (False, said)


@pytest.mark.parametrize(("words", "wer", "shown"), [("up", 1.0, "stop"), ("pull more", 0.0, "")])
def test_of_what_follows_a_stop_in_one_breath_a_command_is_shown(node, words, wer, shown):
    node._theatre.see_sound(-31.0)
    node._on_utterance(Utterance(command="stop", transcript="stop", wer=[0.0]))
    node._on_utterance(Utterance(transcript=words, wer=[wer, 1.0], reason_code="same_breath"))
    assert node._theatre.snapshot().hearing.utterance.command == shown

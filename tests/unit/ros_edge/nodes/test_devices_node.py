# SPDX-License-Identifier: BSD-3-Clause
"""The devices node calls what is said to a voice node, and says what became of a call."""

import socket
import threading
import time
from contextlib import nullcontext
from types import SimpleNamespace

import pytest
import rospy
from std_srvs.srv import SetBoolResponse

from support.waiting import wait_until
from typed_config import ConfigError, load_yaml
from typed_config.ros.launch_settings import RESTART
from typed_config.ros.service_calls import Reply
from voice_assist.config import CONFIG_DIR
from voice_assist.config.devices import DeviceCallConfig, devices_config
from voice_assist.devices.calls import CallResult, DeviceCalls
from voice_assist.msg import Utterance
from voice_assist.ros.devices import node as node_module
from voice_assist.ros.devices import targets
from voice_assist.ros.devices.node import DevicesNode, main, spoken_commands

LAMP = {"phrase": "light on", "kind": "service", "target": "/lamp", "within": 2.0}
LAMP |= {"type": "std_srvs/SetBool", "arguments": "{data: true}", "on_stop": ""}
PLAYER = LAMP | {"phrase": "music", "kind": "topic", "type": "std_msgs/Bool", "within": 0.1}
VACUUM = LAMP | {"phrase": "tidy up", "kind": "action", "type": "rst_control/Assist"}
VACUUM |= {"arguments": "{command: clean}", "within": 0.1}
OFF = LAMP | {"phrase": "off", "arguments": "{data: false}"}


def test_without_a_voice_node_it_is_named(monkeypatch):
    monkeypatch.setattr(rospy, "get_param", lambda name, default: default)
    words = r"voice_assist/commands is missing, allowed: the commands of a voice node"
    with pytest.raises(ConfigError, match=words):
        spoken_commands()


def test_what_can_be_said_is_what_the_voice_node_was_launched_with(monkeypatch):
    given = {"voice_assist/commands": load_yaml(CONFIG_DIR / "commands.yaml")}
    monkeypatch.setattr(rospy, "get_param", lambda name, default: given.get(name, default))
    assert "stop" in spoken_commands().phrases


@pytest.mark.parametrize("is_sent", [False, True])
def test_a_call_that_failed_is_not_made_later_or_says_that_it_may_be(monkeypatch, is_sent):
    reply = Reply(None, "no answer within 2 s", is_sent)
    monkeypatch.setattr(targets, "call_service", lambda *_, **__: reply)
    result = targets.make_target(DeviceCallConfig(**LAMP)).call()
    words = "no answer within 2 s" + ("; it may still be carried out" if is_sent else "")
    assert (result.is_done, result.words) == (False, words)
    assert result.may_have_effect is is_sent


@pytest.mark.parametrize("is_taken", [True, False])
def test_a_device_that_refuses_has_done_nothing(monkeypatch, is_taken):
    reply = Reply(SetBoolResponse(is_taken, "so"))
    monkeypatch.setattr(targets, "call_service", lambda *_, **__: reply)
    result = targets.make_target(DeviceCallConfig(**LAMP)).call()
    assert (result.is_done, result.words, result.may_have_effect) == (is_taken, "so", is_taken)


@pytest.mark.parametrize("is_refused", [True, False])
def test_the_node_does_not_undo_at_a_stop_what_a_device_refused(is_refused):
    node = object.__new__(DevicesNode)
    node._calls = DeviceCalls(devices_config({"calls": [LAMP | {"on_stop": "off"}, OFF]}))
    node._calls.said("light on")
    call, reported = node._calls.next(0.0), []
    result = CallResult(call, not is_refused, "", may_have_effect=not is_refused)
    node._targets = {"light on": SimpleNamespace(call=lambda _: result)}
    node._report = reported.append
    node._make(call, lambda: False)
    node._calls.stopped()
    undo = node._calls.next_undoing(0.0)
    assert reported == [result] and (undo is None) is is_refused


@pytest.fixture
def kept(monkeypatch):
    """What the master keeps of the node."""
    kept = {}

    def ask(_, method, caller, name, value):
        assert (method, caller) == ("setParam", "/devices")
        kept[name] = value

    monkeypatch.setattr(node_module, "ask", ask)
    monkeypatch.setattr(rospy, "get_name", lambda: "/devices")
    monkeypatch.setattr(rospy, "resolve_name", lambda name: name.replace("~", "/devices/"))
    return kept


def node_of_lamp(monkeypatch, *phrases):
    """A node that has to undo calls of one before; nothing is sent, all is done."""
    for name in ("Publisher", "Subscriber"):
        monkeypatch.setattr(rospy, name, lambda *_, **__: None)
    monkeypatch.setattr(node_module, "Believed", lambda: SimpleNamespace(hear=lambda *_: None))
    config = devices_config({"calls": [LAMP | {"on_stop": "off"}, OFF]})
    node = DevicesNode(config, SimpleNamespace(phrases=()), phrases)
    for call in config.calls:
        done = CallResult(call, True, "")
        node._targets[call.phrase] = SimpleNamespace(call=lambda _, done=done: done)
    node._report = lambda _: None
    return node


def test_what_a_stop_has_to_undo_is_kept_before_the_call_and_until_it_is_undone(monkeypatch, kept):
    node, seen = node_of_lamp(monkeypatch), []
    monkeypatch.setattr(node, "_make", lambda *_: seen.append(dict(kept)))
    monkeypatch.setattr(rospy, "is_shutdown", lambda: bool(seen))
    node._calls.said("light on")
    node._make_calls()
    assert seen == [{"/devices/to_undo": ["light on"]}]
    node._calls.stopped()
    node._calls.ended(CallResult(node._calls.next_undoing(0.0), True, ""))
    node._keep()
    assert kept == {"/devices/to_undo": []}


@pytest.mark.parametrize("phrases", [(), ("light on",)])
def test_a_node_that_starts_again_undoes_at_once_what_the_one_before_had_to(monkeypatch, phrases):
    node = node_of_lamp(monkeypatch, *phrases)
    undo = node._calls.next_undoing(0.0)
    assert (undo and undo.phrase) == ("off" if phrases else None)
    assert node._calls.next_undoing(0.0) is None


def test_a_master_that_does_not_answer_keeps_no_call_from_being_made(monkeypatch, kept):
    def ask(*_):
        raise TimeoutError("timed out")

    said, made = [], []
    node = node_of_lamp(monkeypatch)
    monkeypatch.setattr(node_module, "ask", ask)
    monkeypatch.setattr(rospy, "logwarn_throttle", lambda _, words, error: said.append(error))
    monkeypatch.setattr(node, "_make", lambda call, _: made.append(call.phrase))
    monkeypatch.setattr(rospy, "is_shutdown", lambda: len(made) == 2)
    for _ in range(2):
        node._calls.said("light on")
    node._make_calls()
    assert made == ["light on"] * 2
    assert [str(error) for error in said] == ["timed out"] * 2


@pytest.mark.parametrize("is_restart", [True, False])
def test_what_an_earlier_launch_left_is_not_undone(monkeypatch, is_restart):
    given = {"calls": [LAMP], "to_undo": ["light on"], "goal": ["tidy up", "goal 1"]}
    made = []
    node = SimpleNamespace(run=lambda: None)
    monkeypatch.setattr(node_module, "starting", lambda *_, **__: nullcontext())
    monkeypatch.setattr(node_module, "launch_settings", lambda own: given if own else {})
    monkeypatch.setattr(node_module, "stay_registered", lambda: None)
    for name in ("spoken_commands", "require_harmless"):
        monkeypatch.setattr(node_module, name, lambda *_: None)
    monkeypatch.setattr(node_module, "DevicesNode", lambda *words: made.append(words[2:]) or node)
    if is_restart:
        monkeypatch.setenv(RESTART, "1")
    else:
        monkeypatch.delenv(RESTART, raising=False)
    main()
    assert made == [(["light on"], ["tidy up", "goal 1"]) if is_restart else ([], [])]


@pytest.fixture
def connected():
    """A publisher as rospy has it, and the end of its subscriber."""
    with socket.create_server(("127.0.0.1", 0)) as listening:
        far = socket.create_connection(listening.getsockname())
        near, _ = listening.accept()
    sent = []
    connection = SimpleNamespace(socket=near, done=False, endpoint_id="/lamp")
    impl = SimpleNamespace(connections=[connection])
    topic = SimpleNamespace(
        impl=impl,
        sent=sent,
        publish=sent.append,
        get_num_connections=lambda: len(impl.connections),  # rospy's, until a write fails
    )
    with near, far:
        yield topic, far


@pytest.mark.parametrize("given", [PLAYER, VACUUM], ids=["topic", "action"])
@pytest.mark.parametrize("is_there", [True, False])
def test_nothing_is_sent_to_a_node_that_has_ended(monkeypatch, connected, given, is_there):
    topic, far = connected
    monkeypatch.setattr(targets, "_publisher", lambda *_: topic)
    monkeypatch.setattr(rospy, "Subscriber", lambda *_, **__: None)
    monkeypatch.setattr(rospy, "get_name", lambda: "/devices")
    if not is_there:
        far.close()
    began = time.monotonic()
    result = targets.make_target(DeviceCallConfig(**given)).call()
    assert time.monotonic() - began < 5.0
    assert bool(topic.sent) is is_there
    assert result.may_have_effect is is_there
    assert ("nobody" in result.words) is not is_there
    assert result.is_done is (is_there and given is PLAYER)


# An action at work where the node is killed: only a goal's id cancels it, and no goal of others.

VENT = LAMP | {"phrase": "vent", "kind": "action", "type": "rst_control/Assist"}
VENT |= {"arguments": "{command: vent}", "target": "/vent", "within": 0.1}


class Topic:
    """A publisher whose listeners a test sets."""

    def __init__(self):
        self.sent, self.listeners, self.on_publish = [], {"/server"}, lambda: None

    def publish(self, message):
        self.on_publish()
        self.sent.append(message)


def undo(node):
    """What the thread of a start does, until ROS ends."""
    node._undo()
    for thread in threading.enumerate():
        if thread.name == "calls":
            thread.join(10.0)
            assert not thread.is_alive()


@pytest.fixture
def node_of_actions(monkeypatch, kept):
    """Makes a node of two actions, of which one undoes the other, and gives it with its topics."""
    topics = {}
    for name in ("Publisher", "Subscriber"):
        monkeypatch.setattr(rospy, name, lambda *_, **__: None)
    monkeypatch.setattr(node_module, "Believed", lambda: SimpleNamespace(hear=lambda *_: None))
    monkeypatch.setattr(targets, "_publisher", lambda at, _: topics.setdefault(at, Topic()))
    monkeypatch.setattr(targets, "open_listeners", lambda topic: topic.listeners)
    monkeypatch.setattr(targets, "CANCEL_WITHIN", 0.05)

    def make(*left):
        config = devices_config({"calls": [VACUUM | {"on_stop": "vent"}, VENT]})
        node = DevicesNode(config, SimpleNamespace(phrases=()), *left)
        node.results = []
        node._report = node.results.append
        return node, topics

    return make


def test_the_goal_of_an_action_is_kept_before_it_is_sent_and_until_it_has_ended(
    node_of_actions, kept
):
    node, topics = node_of_actions()
    at_work = []
    topics["/lamp/goal"].on_publish = lambda: at_work.append(kept["/devices/goal"])
    node._calls.said("tidy up")
    node._make(node._calls.next(0.0), lambda: False)
    (goal,), (cancel,) = topics["/lamp/goal"].sent, topics["/lamp/cancel"].sent
    assert at_work == [["tidy up", goal.goal_id.id]] and goal.goal_id.id
    assert kept["/devices/goal"] == []
    assert (cancel.id, cancel.stamp) == (goal.goal_id.id, rospy.Time())  # a stamp: of all before


def test_the_goal_of_what_a_stop_makes_is_not_kept_as_no_stop_cancels_it(node_of_actions, kept):
    node, topics = node_of_actions()
    node._calls.said("vent")
    node._make(node._calls.next(0.0), lambda: False)
    assert len(topics["/vent/goal"].sent) == 1 and "/devices/goal" not in kept


@pytest.mark.parametrize("is_served", [True, False])
def test_a_node_that_starts_again_cancels_the_action_at_work_and_then_undoes_it(
    monkeypatch, node_of_actions, kept, is_served
):
    node, topics = node_of_actions(["tidy up"], ["tidy up", "goal 1"])
    cancel = topics["/lamp/cancel"]
    cancel.listeners = {"/server"} if is_served else set()
    undone = []
    topics["/vent/goal"].on_publish = lambda: undone.append(len(cancel.sent))
    monkeypatch.setattr(rospy, "is_shutdown", lambda: bool(undone))
    undo(node)
    assert undone == [int(is_served)]
    assert [(sent.id, sent.stamp) for sent in cancel.sent] == [("goal 1", rospy.Time())] * is_served
    assert ("cancelled" in node.results[0].words) is is_served
    assert node.results[0].call.phrase == "tidy up" and not node.results[0].is_done
    assert kept["/devices/goal"] == []


@pytest.mark.parametrize("left", [["tidy up"], ["no phrase any more", "goal 1"], ["tidy up", 3]])
def test_a_goal_that_cannot_be_cancelled_keeps_nothing_from_being_undone(
    monkeypatch, node_of_actions, left
):
    node, topics = node_of_actions(["tidy up"], left)
    monkeypatch.setattr(rospy, "logerr", lambda *_: None)
    monkeypatch.setattr(rospy, "is_shutdown", lambda: bool(topics["/vent/goal"].sent))
    undo(node)
    assert len(topics["/vent/goal"].sent) == 1


def test_a_node_that_starts_without_an_action_at_work_cancels_nothing(monkeypatch, node_of_actions):
    node, topics = node_of_actions()
    looks = []
    monkeypatch.setattr(rospy, "is_shutdown", lambda: looks.append(1) or len(looks) > 2)
    undo(node)
    assert not any(topic.sent for topic in topics.values()) and node.results == []


def test_a_result_of_the_start_is_published_once_those_who_show_it_are_connected(monkeypatch, kept):
    """What undoes calls waits for none of it."""
    monkeypatch.setattr(node_module, "HEARD_AFTER", 1.5)
    monkeypatch.setattr(node_module, "IDLE", 0.01)
    monkeypatch.setattr(rospy, "get_time", time.time)
    monkeypatch.setattr(rospy.Time, "now", lambda: rospy.Time.from_sec(time.time()))
    began = time.monotonic()
    node, published = node_of_lamp(monkeypatch, "light on"), []
    del node._report
    publish = lambda message: published.append(time.monotonic() - began)  # noqa: E731
    node._result = node._say = SimpleNamespace(publish=publish)
    node._phrases = ()
    monkeypatch.setattr(rospy, "is_shutdown", lambda: not node._calls.to_undo())
    undo(node)
    assert node._calls.to_undo() == [] and not published
    wait_until(lambda: len(published) == 2)
    assert min(published) >= 1.5
    node._report(CallResult(DeviceCallConfig(**OFF), True, ""))
    assert len(published) == 4  # later on, at once


# The recorder and Foxglove listen to every topic; they are no device.


@pytest.mark.parametrize("given", [PLAYER, VACUUM], ids=["topic", "action"])
@pytest.mark.parametrize(
    ("namespace", "listener", "is_device"),
    [
        ("/", "/recorder", False),
        ("/", "/foxglove", False),
        ("/", "/theatre/recorder", True),
        ("/left/", "/left/recorder", False),
        ("/left/", "/recorder", True),
    ],
)
def test_who_listens_to_every_topic_is_no_device(
    monkeypatch, connected, given, namespace, listener, is_device
):
    topic, _ = connected
    topic.impl.connections[0].endpoint_id = listener
    monkeypatch.setattr(targets, "_publisher", lambda *_: topic)
    monkeypatch.setattr(rospy, "Subscriber", lambda *_, **__: None)
    monkeypatch.setattr(rospy, "get_name", lambda: "/devices")
    monkeypatch.setattr(rospy, "get_namespace", lambda: namespace)
    result = targets.make_target(DeviceCallConfig(**given)).call()
    assert bool(topic.sent) is result.may_have_effect is is_device
    assert ("nobody" in result.words) is not is_device


def test_what_an_earlier_node_left_is_cancelled_once_more_than_the_recorder_listens(monkeypatch):
    seen = []

    def listeners(_):
        seen.append({"/recorder"} if len(seen) < 3 else {"/recorder", "/server"})
        assert not topic.sent
        return seen[-1]

    topic = Topic()
    monkeypatch.setattr(targets, "_publisher", lambda *_: topic)
    monkeypatch.setattr(targets, "open_listeners", listeners)
    result = targets.cancel_left(DeviceCallConfig(**VACUUM), "goal 1")
    assert [sent.id for sent in topic.sent] == ["goal 1"] and "cancelled" in result.words
    assert len(seen) == 4


# What was said long ago, as before a hang or on a link that was gone.

NOW = 1700000000.0


@pytest.mark.parametrize("of", ["decision", "header"])
@pytest.mark.parametrize(
    ("age", "is_wallclock", "words"),
    [
        (0.0, True, ""),
        (1.9, True, ""),
        (2.1, True, "said 2.1 s ago, allowed 2 s"),
        (10.0, True, "said 10.0 s ago, allowed 2 s"),
        (-0.1, True, ""),
        (-5.0, True, "said 5.0 s ahead of this host's clock, allowed 0.2 s; run chrony"),
        (None, True, ""),
        (10.0, False, ""),
    ],
)
def test_words_of_long_ago_call_no_device(monkeypatch, kept, of, age, is_wallclock, words):
    monkeypatch.setattr(rospy, "get_time", lambda: NOW)
    monkeypatch.setattr(rospy.rostime, "is_wallclock", lambda: is_wallclock)
    node, published = node_of_lamp(monkeypatch), []
    del node._report
    node._heard_at, node._phrases = 0.0, ()
    node._result = SimpleNamespace(publish=published.append)
    node._say = SimpleNamespace(publish=lambda _: None)
    monkeypatch.setattr(rospy.Time, "now", lambda: rospy.Time.from_sec(NOW))
    message, stamp = Utterance(command="light on"), rospy.Time.from_sec(NOW - (age or 0.0))
    if age is not None and of == "decision":
        message.decision, message.header.stamp = stamp, rospy.Time.from_sec(NOW)
    elif age is not None:
        message.header.stamp = stamp
    node._on_utterance(message)
    call = node._calls.next(0.0)
    assert (call is None) is bool(words)
    assert [(m.phrase, m.is_done, m.message) for m in published] == [
        ("light on", False, words)
    ] * bool(words)


def test_of_words_of_long_ago_that_call_no_device_nothing_is_said(monkeypatch, kept):
    node, reported = node_of_lamp(monkeypatch), []
    node._report = reported.append
    for command in ("pull more", "", "light on"):
        message = Utterance(command=command)
        message.header.stamp = rospy.Time.from_sec(1.0)
        node._on_utterance(message)
    (result,) = reported
    assert result.call.phrase == "light on" and not result.may_have_effect
    assert node._calls.next(0.0) is None

# SPDX-License-Identifier: BSD-3-Clause
"""At a stop a call at work holds nothing up: it is given up, and what undoes calls goes beside."""

import threading
from types import SimpleNamespace

import pytest
import rospy

from support.waiting import wait_until
from voice_assist.config.devices import DeviceCallConfig, devices_config
from voice_assist.devices.calls import DROPPED, CallResult, DeviceCalls
from voice_assist.ros.devices import targets
from voice_assist.ros.devices.node import DevicesNode
from voice_assist.ros.devices.targets import make_target

LAMP = {"kind": "service", "target": "/lamp", "type": "std_srvs/SetBool", "within": 60.0}
LAMP |= {"arguments": "{data: true}"}
LIGHT = (
    {**LAMP, "phrase": "light on", "on_stop": "go dark"},
    {**LAMP, "phrase": "go dark", "on_stop": ""},
)
VACUUM = {"phrase": "tidy up", "kind": "action", "target": "/vacuum", "within": 60.0}
VACUUM |= {"type": "rst_control/Assist", "arguments": "{command: clean}", "on_stop": ""}
PLAYER = {"phrase": "music", "kind": "topic", "target": "/player", "within": 60.0}
PLAYER |= {"type": "std_msgs/Bool", "arguments": "{data: true}", "on_stop": ""}


class Target:
    """A device, which may hang."""

    def __init__(self, given, may_end=None):
        self.config, self.may_end = DeviceCallConfig(**given), may_end
        self.called = threading.Event()

    def call(self, is_stopped=None):
        self.called.set()
        if self.may_end is not None:
            self.may_end.wait(60.0)
        return CallResult(self.config, True, "")


def test_what_a_stop_undoes_does_not_wait_for_a_call_that_hangs(monkeypatch):
    """When that call ends after all, it is undone again."""
    may_end, is_over = threading.Event(), threading.Event()
    monkeypatch.setattr(rospy, "is_shutdown", is_over.is_set)
    node = object.__new__(DevicesNode)
    told = threading.Semaphore(0)
    node._known = SimpleNamespace(publish_status=told.release)
    node._keep, node._left = lambda: None, ()
    node._calls = DeviceCalls(devices_config({"calls": list(LIGHT)}))
    light, dark = Target(LIGHT[0], may_end), Target(LIGHT[1])
    node._targets = {"light on": light, "go dark": dark}
    results = []
    node._report = lambda result: results.append(result.call.phrase)
    working = threading.Thread(target=node.run, daemon=True)
    working.start()
    node._calls.said("light on")
    assert light.called.wait(10.0)
    node._on_stop()
    assert dark.called.wait(10.0)
    wait_until(lambda: results == ["go dark"])
    assert all(told.acquire(timeout=10.0) for _ in range(20))  # it is not silent meanwhile
    may_end.set()
    wait_until(lambda: sorted(results) == ["go dark", "go dark", "light on"])
    is_over.set()
    own = [each for each in threading.enumerate() if each.name in ("calls", "undo")]
    for thread in (working, *own):
        thread.join(10.0)  # before rospy is the true one again
        assert not thread.is_alive()


class Topic:
    """Stands for a publisher."""

    def __init__(self, listeners):
        self.listeners, self.sent = listeners, []

    def publish(self, message):
        self.sent.append(message)


@pytest.fixture
def topics(monkeypatch):
    topics = {}
    monkeypatch.setattr(rospy, "Subscriber", lambda *_, **__: None)
    monkeypatch.setattr(targets, "open_listeners", lambda topic: topic.listeners)
    monkeypatch.setattr(rospy, "get_name", lambda: "/devices")
    monkeypatch.setattr(
        targets, "_publisher", lambda target, _: topics.setdefault(target, Topic({"/x"}))
    )
    return topics


def test_a_stop_cancels_an_action_at_work(topics):
    target = make_target(DeviceCallConfig(**VACUUM))
    goals = topics["/vacuum/goal"].sent
    result = target.call(lambda: bool(goals))  # the stop comes as soon as the goal is out
    assert (result.is_done, result.words) == (False, "a stop came; cancelled")
    assert result.may_have_effect
    assert [goal_id.id for goal_id in topics["/vacuum/cancel"].sent] == [goals[0].goal_id.id]


@pytest.mark.parametrize("given", [VACUUM, PLAYER])
@pytest.mark.parametrize("listeners", [set(), {"/x"}])
def test_after_a_stop_nothing_goes_out(topics, given, listeners):
    target = make_target(DeviceCallConfig(**given))
    for topic in topics.values():
        topic.listeners = listeners
    result = target.call(lambda: True)
    assert (result.words, result.may_have_effect) == (DROPPED, False)
    assert not any(topic.sent for topic in topics.values())


def test_a_request_that_is_not_out_at_a_stop_stays_unsent(monkeypatch):
    written = []

    class Service:
        transport = None

        def __call__(self, request):
            request.serialize(SimpleNamespace(write=written.append))

        def close(self):
            pass

    monkeypatch.setattr(rospy, "ServiceProxy", lambda *_, **__: Service())
    result = make_target(DeviceCallConfig(**LIGHT[0])).call(lambda: True)
    assert (result.is_done, result.words) == (False, "given up before it was sent")
    assert written == []

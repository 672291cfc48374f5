# SPDX-License-Identifier: BSD-3-Clause
"""Nodes of the real arm: what is sent while one ends, and what its threads do to each other."""

import threading
from types import SimpleNamespace

import numpy as np
import pytest

from bench.kinova.rig import kinova_motion
from rst_control.config.torque_tension import load_torque_tension
from rst_control.kinova.bridge import Bridge
from rst_control.kinova.config import load_kinova_config
from rst_control.kinova.guard import StopGuard
from rst_control.msg import BridgeBeat
from rst_control.ros.common.wall_clock import RosClock
from rst_control.ros.controller import node as controller_node
from rst_control.ros.kinova import arm_report, bridge_node, guard_node, hardware
from rst_control.ros.kinova.arm_report import FIRMWARE_TRIES, ArmFacts
from rst_control.ros.kinova.bridge_node import KinovaBridgeNode
from rst_control.ros.kinova.guard_node import GuardNode
from rst_control.ros.kinova.hardware import KinovaHardware
from rst_control.ros.simulator import node as simulator_node
from rst_control.ros.torque_tension_node import SOONER


class Topic:
    """Notes what is published on it, among all that is sent."""

    def __init__(self, name, sent):
        self.name, self.sent = name, sent

    def publish(self, _):
        self.sent.append(self.name)


class Socket:
    """One on which nothing is to be read, or that the other end closed."""

    def __init__(self, is_closed=False):
        self.is_closed = is_closed

    def recv(self, *_):
        if self.is_closed:
            return b""
        raise BlockingIOError


class ToArm:
    """A topic of the arm's driver, with the names of its subscribers."""

    def __init__(self, name, *listeners):
        self.resolved_name = f"/my_gen3/in/{name}"
        connections = [
            SimpleNamespace(endpoint_id=listener, done=False, socket=Socket())
            for listener in listeners
        ]
        self.impl = SimpleNamespace(connections=connections)


class Plan:
    """Braking in three steps."""

    left = 3

    @property
    def is_over(self):
        return self.left == 0

    def step(self, _):
        self.left -= 1
        return SimpleNamespace(tolist=lambda: [0.1] * 7)


DRIVER, RECORDER = "/my_gen3/my_gen3_driver", "/recorder"


@pytest.fixture(autouse=True)
def at_once(monkeypatch):
    monkeypatch.setattr(hardware.time, "sleep", lambda _: None)


def closed(plan):
    """What is sent by hardware that is closed."""
    sent, arm = [], object.__new__(KinovaHardware)
    arm._speeds, arm._stop, arm._is_closed = Topic("speeds", sent), Topic("stop", sent), False
    arm.close(plan, lambda: sent.append("beat"))
    return arm, sent


def test_the_guard_hears_a_beat_with_each_velocity_and_with_each_stop_of_the_end():
    _, sent = closed(Plan())
    assert sent[:6] == ["speeds", "beat"] * 3
    assert sent[6:] == ["stop", "beat"] * (len(sent[6:]) // 2) and len(sent) > 8


def test_an_arm_that_is_not_led_is_stopped_and_the_guard_hears_it():
    arm, sent = closed(None)
    assert set(sent) == {"stop", "beat"}
    before = len(sent)
    arm.send_speeds(None)
    assert len(sent) == before


def test_the_loop_leads_nobody_while_the_bridge_is_closed(monkeypatch):
    """rospy calls what is to be done at the end before it says that it ends."""
    rounds, looks = [], iter([False] * 5 + [True])
    node = object.__new__(KinovaBridgeNode)
    node._config, node._latest, node._is_closing = SimpleNamespace(rate=200.0), 0.0, False
    node._bridge = SimpleNamespace(brake_plan=lambda _: None)
    node._hardware = SimpleNamespace(close=lambda plan, beat: None)
    node._config.arm = SimpleNamespace(period=0.025)

    def one_round():
        rounds.append(1)
        if len(rounds) == 2:
            node.close()
        return 0.0

    node._round = one_round
    monkeypatch.setattr(bridge_node, "ask_for_priority", lambda: "none")
    monkeypatch.setattr(bridge_node.rospy, "is_shutdown", lambda: next(looks))
    node.run()
    assert len(rounds) == 2


def test_a_beat_waits_until_the_guard_has_sent_what_it_decided():
    sent, looks, goes_on = [], threading.Event(), threading.Event()

    def speeds_due(_):
        looks.set()
        assert goes_on.wait(30.0)
        return SimpleNamespace(tolist=lambda: [0.1] * 7)

    node = object.__new__(GuardNode)
    node._lock, node._speeds = threading.Lock(), Topic("speeds", sent)
    heard = SimpleNamespace(heard=lambda *_: sent.append("heard"), speeds_due=speeds_due)
    node._guard = heard
    guarding = threading.Thread(target=node._guard_once)
    guarding.start()
    assert looks.wait(30.0)
    beating = threading.Thread(target=node._on_beat, args=(BridgeBeat(),))
    beating.start()
    beating.join(0.05)
    goes_on.set()
    guarding.join()
    beating.join()
    assert sent == ["speeds", "heard"]


def test_the_guard_says_that_it_is_there_only_while_it_hears_the_bridge(monkeypatch):
    config = load_kinova_config().bridge
    alive, rounds, guard = [], [], StopGuard(config)
    node = object.__new__(GuardNode)
    node._lock, node._guard, node._stop = threading.Lock(), guard, Topic("stop", [])
    node._known = SimpleNamespace(publish_status=lambda: None)
    node._say_alive = lambda: alive.append(len(rounds))
    monkeypatch.setattr(guard_node.rospy, "logerr", lambda *_: None)
    monkeypatch.setattr(guard_node.rospy, "is_shutdown", lambda: len(rounds) >= 300)
    monkeypatch.setattr(guard_node.time, "monotonic", lambda: len(rounds) * guard_node.PERIOD)

    def one_round(_):
        rounds.append(1)
        if 100 <= len(rounds) < 200:
            guard.heard(guard_node.time.monotonic())

    monkeypatch.setattr(guard_node.time, "sleep", one_round)
    node.run()
    silence = config.guard.silence / guard_node.PERIOD
    assert alive and alive[0] >= 100 and alive[-1] <= 200 + silence
    assert len(alive) >= 25


def sent_by_guard(monkeypatch, stop, velocity, drivers=("/robot", "/my_gen3/*")):
    """What a guard that hears the bridge sends to it and logs."""
    sent, logged, node = [], [], object.__new__(GuardNode)
    node._stop, node._speeds, node._drivers = stop, velocity, drivers
    node._alive = Topic("alive", sent)
    log = lambda _, words, *values: logged.append(words % values)  # noqa: E731
    monkeypatch.setattr(guard_node.rospy, "logwarn_throttle", log)
    node._say_alive()
    return sent, logged


STOP, VELOCITY = "/my_gen3/in/stop", "/my_gen3/in/joint_velocity"


@pytest.mark.parametrize(
    ("stop", "velocity", "unheard"),
    [
        ([], [], f"{STOP}, {VELOCITY}"),
        ([RECORDER], [RECORDER], f"{STOP}, {VELOCITY}"),
        ([DRIVER], [RECORDER], VELOCITY),
        ([], [DRIVER], STOP),
    ],
)
def test_a_guard_that_the_driver_does_not_hear_is_no_guard(monkeypatch, stop, velocity, unheard):
    topics = ToArm("stop", *stop), ToArm("joint_velocity", *velocity)
    sent, logged = sent_by_guard(monkeypatch, *topics)
    assert sent == []
    words = f"the arm's driver does not hear this guard: {unheard}; allowed: /robot, /my_gen3/*"
    assert logged == [words]


@pytest.mark.parametrize("driver", [DRIVER, "/robot"])
def test_a_guard_that_the_driver_hears_on_both_topics_is_one(monkeypatch, driver):
    topics = ToArm("stop", RECORDER, driver), ToArm("joint_velocity", driver)
    assert sent_by_guard(monkeypatch, *topics) == (["alive"], [])


def test_where_the_settings_name_nobody_any_listener_counts_for_the_driver(monkeypatch):
    topics = ToArm("stop", "/other"), ToArm("joint_velocity", "/other")
    assert sent_by_guard(monkeypatch, *topics, drivers=()) == (["alive"], [])
    sent, (words,) = sent_by_guard(monkeypatch, ToArm("stop"), topics[1], drivers=())
    assert sent == [] and words.endswith(f"{STOP}; allowed: anybody")


@pytest.mark.parametrize(
    ("done", "socket"), [(True, Socket()), (False, None), (False, Socket(is_closed=True))]
)
def test_a_driver_whose_connection_is_closed_does_not_hear(monkeypatch, done, socket):
    stop, velocity = ToArm("stop", DRIVER), ToArm("joint_velocity", DRIVER)
    (connection,) = stop.impl.connections
    connection.done, connection.socket = done, socket
    sent, logged = sent_by_guard(monkeypatch, stop, velocity)
    assert sent == [] and f"{STOP};" in logged[0]


@pytest.mark.parametrize("node", [controller_node, simulator_node, bridge_node, guard_node])
def test_each_node_that_moves_the_robot_first_bounds_what_it_takes_in(monkeypatch, node):
    """Else a peer that connects and says nothing keeps everybody else from connecting."""

    class BoundedError(Exception):
        pass

    def limit():
        raise BoundedError

    monkeypatch.setattr(node, "limit_messages", limit)
    with pytest.raises(BoundedError):
        node.main()


def test_a_force_is_published_once_and_the_controller_judges_its_age():
    published, now, node = [], 100.0, object.__new__(KinovaBridgeNode)
    bridge = Bridge(load_kinova_config(), None)
    node._bridge, node._told_force, node._clock = bridge, None, RosClock()
    node._tension = SimpleNamespace(
        publish=lambda message: published.append(message.wrench.force.z)
    )
    for value in (1.0, 1.0, 1.5):  # a new one counts as new, whatever it says
        bridge.on_force(np.array([0.0, 0.0, value]), now)
        for _ in range(4):
            node._publish_tension(now)
            now += 0.025
    assert published == [1.0, 1.0, 1.5]


@pytest.mark.parametrize("lost", [0, 1, 2])
def test_an_estimate_of_the_arms_own_torques_never_grows_too_old_for_the_controller(lost):
    """Each state of the arm gives an estimate, but those that come too soon after one another."""
    watchdogs, published = kinova_motion().controller.watchdogs, []
    bridge, node = Bridge(load_kinova_config(), None), object.__new__(KinovaBridgeNode)
    node._bridge, node._told_force, node._clock = bridge, None, RosClock()
    node._tension = SimpleNamespace(publish=lambda _: published.append(now))
    closest = (1.0 - SOONER) / load_torque_tension().rate
    late = np.random.default_rng(4).uniform(0.0, 0.004, 2000)  # [s] of each state
    states = [0.025 * k + late[k] for k in range(2000) if k % 20 >= lost]
    taken, ages = -np.inf, []
    for now in states:
        node._publish_tension(now)
        ages += [now - published[-1]] if published else []
        if now - taken >= closest:
            taken = now
            bridge.on_force(np.array([0.0, 0.0, 1.0]), now + 0.005)
    assert max(ages) > 0.02  # some are too soon
    assert max(ages) <= max(watchdogs.sensors.tension_age, watchdogs.joint_state_age)


@pytest.fixture
def facts(monkeypatch):
    """Of an arm whose limits nobody wants; what is asked is up to the test."""
    monkeypatch.setattr(arm_report.rospy, "logwarn_throttle", lambda *_: None)
    facts = object.__new__(ArmFacts)
    facts._namespace, facts._is_wanted, facts.firmware = "my_gen3", lambda: False, ""
    return facts


@pytest.mark.parametrize(("answers", "firmware"), [([None, "2.5.2"], "2.5.2"), ([None] * 99, "")])
def test_the_firmware_is_asked_for_a_few_times_whether_limits_are_read_or_not(
    monkeypatch, facts, answers, firmware
):
    asked, looks = [], []

    def ask(_):
        answer = answers[len(asked)]
        asked.append(answer)
        if answer is None:
            raise arm_report.rospy.ROSException("no answer")
        return answer

    monkeypatch.setattr(arm_report, "ask_firmware", ask)
    monkeypatch.setattr(arm_report.rospy, "is_shutdown", lambda: len(looks) > 20)
    monkeypatch.setattr(arm_report.time, "sleep", looks.append)
    facts._ask()
    assert facts.firmware == firmware
    assert len(asked) == (2 if firmware else FIRMWARE_TRIES)


@pytest.mark.parametrize(
    "error",
    [
        arm_report.rospy.ServiceException("no"),
        arm_report.rospy.exceptions.TransportTerminated("gone in the midst of a call"),
        ConnectionResetError("gone"),
    ],
)
def test_a_driver_that_is_lost_in_the_midst_of_a_question_is_asked_again(monkeypatch, facts, error):
    asked, limits = [], []

    def ask_limits(_):
        asked.append(1)
        if len(asked) == 1:
            raise error
        return "limits"

    monkeypatch.setattr(arm_report, "ask_limits", ask_limits)
    monkeypatch.setattr(arm_report.rospy, "is_shutdown", lambda: bool(limits))
    monkeypatch.setattr(arm_report.time, "sleep", lambda _: None)
    facts.firmware = "known"
    facts._is_wanted, facts._on_limits = lambda: not limits, limits.append
    facts._ask()
    assert limits == ["limits"]


def test_a_driver_that_comes_late_is_asked_for_its_firmware_anew(monkeypatch, facts):
    asked, rounds, limits = [], [], []

    def ask(_):
        asked.append(len(rounds))
        raise arm_report.rospy.ROSException("no answer")

    def ask_limits(_):
        if len(rounds) < 10:
            raise arm_report.rospy.ROSException("no driver yet")
        return "limits"

    monkeypatch.setattr(arm_report, "ask_firmware", ask)
    monkeypatch.setattr(arm_report, "ask_limits", ask_limits)
    monkeypatch.setattr(arm_report.rospy, "is_shutdown", lambda: len(rounds) > 30)
    monkeypatch.setattr(arm_report.time, "sleep", rounds.append)
    facts._is_wanted, facts._on_limits = lambda: not limits, limits.append
    facts._ask()
    assert sum(at < 10 for at in asked) == sum(at >= 10 for at in asked) == FIRMWARE_TRIES

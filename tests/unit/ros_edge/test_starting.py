# SPDX-License-Identifier: BSD-3-Clause
"""The start of a node: a signal ends it at once, a wrong setting and a missing clock are named."""

import signal
import threading
import time
from contextlib import suppress

import pytest
import rospy

from rst_control.host import respawn
from support.waiting import PATIENCE
from typed_config import ConfigError
from typed_config.ros.starting import WRONG, starting, wait_for_clock

NUMBERS = (signal.SIGINT, signal.SIGTERM)
HANDLED = (*NUMBERS, signal.SIGALRM)


@pytest.fixture
def clock(monkeypatch):
    """Stands for ROS; what it shows one after the other, and errors that were logged."""
    monkeypatch.setattr(rospy, "init_node", lambda name, disable_signals: None)
    monkeypatch.setattr(rospy, "is_shutdown", lambda: False)
    shown, said = [1.0], []
    monkeypatch.setattr(rospy, "get_time", lambda: shown.pop(0) if len(shown) > 1 else shown[0])
    monkeypatch.setattr(rospy, "logerr", said.append)
    return shown, said


@pytest.fixture(autouse=True)
def handlers():
    """Afterwards all are as before."""
    before = {number: signal.getsignal(number) for number in HANDLED}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.mark.parametrize("number", NUMBERS)
def test_a_signal_while_a_node_starts_ends_it_and_the_same_once_more_changes_nothing(clock, number):
    with pytest.raises(SystemExit) as ended, starting("node"):
        signal.raise_signal(number)
    assert ended.value.code == 128 + number
    signal.raise_signal(number)  # while it ends


@pytest.mark.parametrize("number", NUMBERS)
def test_code_that_swallows_the_exit_does_not_start_the_node(clock, number):
    with pytest.raises(SystemExit) as ended, starting("node"), suppress(SystemExit):
        signal.raise_signal(number)
    assert ended.value.code == 128 + number


@pytest.mark.parametrize("number", NUMBERS)
def test_code_that_swallows_the_exit_and_goes_on_gets_it_again(clock, number):
    with pytest.raises(SystemExit) as ended, starting("node"):
        with suppress(SystemExit):
            signal.raise_signal(number)
        time.sleep(60.0)  # no lock is held: an exit within Condition.wait may break it
        pytest.fail("it went on")
    assert ended.value.code == 128 + number
    assert signal.getitimer(signal.ITIMER_REAL) == (0.0, 0.0)


@pytest.mark.parametrize("advice", ["", "alarms.launch"])
def test_a_wrong_setting_is_named_once_and_ends_the_node(clock, logged, advice):
    with pytest.raises(SystemExit) as ended, starting("alarms", launch=advice):
        raise ConfigError("sound.volume", 5.0, "0 to 1")
    assert ended.value.code == WRONG == respawn.WRONG
    words = "alarms cannot start: sound.volume is 5.0, allowed: 0 to 1"
    assert logged == [words + "; launch/alarms.launch starts it" * bool(advice)]


def test_another_error_is_a_crash(clock):
    with pytest.raises(ArithmeticError), starting("alarms"):
        raise ArithmeticError


@pytest.mark.parametrize("number", NUMBERS)
def test_a_node_that_has_started_is_shut_down_beside_what_it_does(clock, monkeypatch, number):
    lock, reasons, is_over = threading.Lock(), [], threading.Event()

    def shut_down(reason):
        with lock:
            reasons.append(reason)
        is_over.set()

    monkeypatch.setattr(rospy.core, "signal_shutdown", shut_down)
    monkeypatch.setattr(rospy.core, "_client_shutdown_hooks", [])
    with starting("node"):
        pass
    with lock:  # what the shutdown needs, too
        signal.raise_signal(number)
        signal.raise_signal(number)  # roslaunch and `respawn` both send it
        assert reasons == []
    assert is_over.wait(PATIENCE)
    assert reasons == [f"signal-{number:d}"]


def test_loops_end_before_the_topics_are_closed(clock, monkeypatch):
    seen, is_over = [], threading.Event()
    state = {
        "_shutdown_flag": False,
        "_in_shutdown": False,
        "_client_shutdown_hooks": [],
        "_preshutdown_hooks": [lambda _: seen.append(rospy.core.is_shutdown())],
        "_shutdown_hooks": [lambda _: is_over.set()],
    }
    for name, value in state.items():
        monkeypatch.setattr(rospy.core, name, value)
    with starting("node"):
        rospy.on_shutdown(lambda: seen.append(rospy.core.is_shutdown()))
    signal.raise_signal(signal.SIGINT)
    assert is_over.wait(PATIENCE)
    assert seen == [False, True]


def test_a_clock_that_comes_soon_is_waited_for_without_a_word(clock, monkeypatch):
    shown, said = clock
    monkeypatch.setattr("typed_config.ros.starting.CLOCK_DUE", PATIENCE)
    shown[:] = [0.0, 0.0, 0.02]
    wait_for_clock()
    assert (shown, said) == ([0.02], [])


def test_a_clock_that_does_not_come_is_named_at_once(clock, monkeypatch):
    shown, said = clock
    monkeypatch.setattr("typed_config.ros.starting.CLOCK_DUE", 0.0)
    shown[:] = [0.0, 0.0, 5.0]
    wait_for_clock()
    (words,) = said
    assert "use_sim_time" in words and "/clock" in words


def test_a_node_without_need_of_the_clock_does_not_wait(clock):
    clock[0][:] = [0.0]
    with starting("recorder", needs_clock=False):
        pass


def test_ctrl_c_ends_a_node_that_waits_for_the_clock(clock, monkeypatch):
    clock[0][:] = [0.0]
    monkeypatch.setattr(
        "typed_config.ros.starting.time.sleep", lambda _: signal.raise_signal(signal.SIGINT)
    )
    with pytest.raises(SystemExit), starting("node"):
        pytest.fail("it started")

# SPDX-License-Identifier: BSD-3-Clause
"""The start of a node: a signal ends it, wrong words, settings and a missing clock are named."""

import json
import re
import signal
import subprocess
import sys
import threading
import time
from contextlib import suppress
from pathlib import Path

import pytest
import rospy

from rst_control.host import respawn
from support.waiting import PATIENCE
from typed_config import ConfigError
from typed_config.ros.starting import WRONG, starting, wait_for_clock

ROOT = Path(__file__).resolve().parents[3]
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
def words(monkeypatch):
    """Gives the node words on its command line, beside those that roslaunch gives every node."""

    def give(*words):
        monkeypatch.setattr("sys.argv", ["node", *words, "__name:=node", "_rate:=5"])

    give()
    return give


@pytest.fixture(autouse=True)
def handlers():
    """Afterwards all are as before."""
    before = {number: signal.getsignal(number) for number in HANDLED}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.fixture
def registered(clock, monkeypatch):
    """Names that were registered: the master ends a node that runs under one of them."""
    names = []
    monkeypatch.setattr(rospy, "init_node", lambda name, **_: names.append(name))
    return names


def test_remappings_and_settings_on_the_command_line_start_the_node(registered):
    with starting("node", __doc__):
        pass
    assert registered == ["node"]


@pytest.mark.parametrize("word", ["-h", "--help"])
def test_help_says_what_a_node_is_and_registers_nothing(registered, words, word, capsys):
    words(word)
    with pytest.raises(SystemExit) as ended, starting("node", __doc__, launch="robot.launch"):
        pytest.fail("it started")
    assert (ended.value.code, registered) == (0, [])
    said = " ".join(capsys.readouterr().out.split())
    assert __doc__ in said and "launch/robot.launch starts it" in said


@pytest.mark.parametrize("word", ["--list", "value", "-x"])
def test_a_word_that_no_node_takes_is_named_and_registers_nothing(registered, words, word, capsys):
    words(word)
    with pytest.raises(SystemExit) as ended, starting("node", __doc__):
        pytest.fail("it started")
    assert (ended.value.code, registered) == (WRONG, [])
    said = capsys.readouterr().err
    assert said.endswith(f"unrecognized arguments: {word}\n")
    assert "usage: node [-h] [name:=value ...]" in said


ASK_ALL = """
import json, runpy, sys
import rospy

rospy.init_node = lambda *_, **__: sys.exit("it is registered")
codes, scripts = {}, sys.argv[1:]
for script in scripts:
    sys.argv = [script, "--help"]
    try:
        runpy.run_path(script, run_name="__main__")
    except SystemExit as ended:
        codes[script] = ended.code
print(json.dumps(codes))
"""


def test_all_programs_but_those_that_the_page_names_take_help():
    """In one process, since their imports take longer than all the rest."""
    page = (ROOT / "docs/reference/programs.md").read_text(encoding="utf-8")
    others = re.findall("`([a-z]+)`", re.search("All but (.*) take `--help`", page)[1])
    scripts = {file.name: str(file) for file in ROOT.glob("catkin_ws/src/*/scripts/*")}
    asked = [scripts[name] for name in sorted(scripts.keys() - set(others))]
    words = [sys.executable, "-c", ASK_ALL, *asked]
    done = subprocess.run(words, capture_output=True, text=True, timeout=60.0, check=True)
    assert len(others) == 2 and len(asked) == len(scripts) - 2
    assert json.loads(done.stdout.splitlines()[-1]) == dict.fromkeys(asked, 0)


@pytest.mark.parametrize("number", NUMBERS)
def test_a_signal_while_a_node_starts_ends_it_and_the_same_once_more_changes_nothing(clock, number):
    with pytest.raises(SystemExit) as ended, starting("node", __doc__):
        signal.raise_signal(number)
    assert ended.value.code == 128 + number
    signal.raise_signal(number)  # while it ends


@pytest.mark.parametrize("number", NUMBERS)
def test_code_that_swallows_the_exit_does_not_start_the_node(clock, number):
    with pytest.raises(SystemExit) as ended, starting("node", __doc__), suppress(SystemExit):
        signal.raise_signal(number)
    assert ended.value.code == 128 + number


@pytest.mark.parametrize("number", NUMBERS)
def test_code_that_swallows_the_exit_and_goes_on_gets_it_again(clock, number):
    with pytest.raises(SystemExit) as ended, starting("node", __doc__):
        with suppress(SystemExit):
            signal.raise_signal(number)
        time.sleep(60.0)  # no lock is held: an exit within Condition.wait may break it
        pytest.fail("it went on")
    assert ended.value.code == 128 + number
    assert signal.getitimer(signal.ITIMER_REAL) == (0.0, 0.0)


@pytest.mark.parametrize("advice", ["", "alarms.launch"])
def test_a_wrong_setting_is_named_once_and_ends_the_node(clock, logged, advice):
    with pytest.raises(SystemExit) as ended, starting("alarms", __doc__, launch=advice):
        raise ConfigError("sound.volume", 5.0, "0 to 1")
    assert ended.value.code == WRONG == respawn.WRONG
    words = "alarms cannot start: sound.volume is 5.0, allowed: 0 to 1"
    assert logged == [words + "; launch/alarms.launch starts it" * bool(advice)]


def test_another_error_is_a_crash(clock):
    with pytest.raises(ArithmeticError), starting("alarms", __doc__):
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
    with starting("node", __doc__):
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
    with starting("node", __doc__):
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
    with starting("recorder", __doc__, needs_clock=False):
        pass


def test_ctrl_c_ends_a_node_that_waits_for_the_clock(clock, monkeypatch):
    clock[0][:] = [0.0]
    monkeypatch.setattr(
        "typed_config.ros.starting.time.sleep", lambda _: signal.raise_signal(signal.SIGINT)
    )
    with pytest.raises(SystemExit), starting("node", __doc__):
        pytest.fail("it started")

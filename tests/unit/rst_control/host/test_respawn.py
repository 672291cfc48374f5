# SPDX-License-Identifier: BSD-3-Clause
"""Who crashes is started anew; a wrong setting, or a wish to end, is the end."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from rst_control.host import respawn
from support.waiting import PATIENCE, wait_until

COUNTED = """
import os, signal, sys
with open(sys.argv[1], "a+") as file:
    file.write(f"{os.getpid()}\\n")
    file.seek(0)
    count = len(file.readlines())
"""

QUICK = "from rst_control.host import respawn; respawn.PAUSE = 0.0; respawn.main()"


def command(tmp_path, then):
    return sys.executable, "-I", "-S", "-c", COUNTED + then, str(tmp_path / "runs")


def pids(tmp_path):
    path = Path(tmp_path / "runs")
    return [int(line) for line in path.read_text().splitlines()] if path.exists() else []


@pytest.fixture(autouse=True)
def quick(monkeypatch):
    monkeypatch.setattr(respawn, "PAUSE", 0.0)


@pytest.mark.parametrize(
    "crash", ["os.kill(os.getpid(), signal.SIGKILL)", "raise ArithmeticError", "os.abort()"]
)
def test_who_crashes_is_started_anew(tmp_path, crash, capfd):
    then = f"if count < 3: {crash}"
    assert respawn.Respawner(command(tmp_path, then)).run() == 0
    assert len(pids(tmp_path)) == 3
    assert capfd.readouterr().err.count("is started anew") == 2


def test_only_what_is_started_again_after_a_crash_finds_that_in_its_environment(tmp_path):
    then = f"assert ({respawn.RESTART!r} in os.environ) == (count > 1)"
    assert respawn.Respawner(command(tmp_path, f"{then}\nif count < 2: os.abort()")).run() == 0
    assert len(pids(tmp_path)) == 2


@pytest.mark.parametrize("status", [0, 2, 7])
def test_who_ends_by_itself_has_ended(tmp_path, status):
    assert respawn.Respawner(command(tmp_path, f"sys.exit({status})")).run() == status
    assert len(pids(tmp_path)) == 1


def test_who_crashes_again_and_again_is_given_up(tmp_path, capfd):
    assert respawn.Respawner(command(tmp_path, "sys.exit(1)")).run() == 1
    assert len(pids(tmp_path)) == respawn.MOST
    assert "is given up" in capfd.readouterr().err


def test_crashes_far_apart_are_not_added_up(tmp_path, monkeypatch):
    monkeypatch.setattr(respawn, "SPAN", -1.0)
    then = f"sys.exit(1 if count <= {respawn.MOST + 1} else 0)"
    assert respawn.Respawner(command(tmp_path, then)).run() == 0
    assert len(pids(tmp_path)) == respawn.MOST + 2


@pytest.mark.parametrize("then", [0, 1, respawn.WRONG, 7])
def test_what_is_always_started_anew_is_so_however_it_ends_later(tmp_path, then):
    ends = f"""
if count <= {respawn.MOST + 1}:
    sys.exit({then} if count > 1 else 1)
os.kill(os.getppid(), signal.SIGINT)
signal.pause()
"""
    words = (sys.executable, "-c", QUICK, "--always", *command(tmp_path, ends))
    subprocess.run(words, env=with_paths(), timeout=PATIENCE, check=False)
    assert len(pids(tmp_path)) == respawn.MOST + 2


def test_a_wrong_setting_at_first_ends_what_is_always_started_anew(tmp_path):
    wrong = command(tmp_path, f"sys.exit({respawn.WRONG})")
    assert respawn.Respawner(wrong, is_always=True).run() == respawn.WRONG
    assert len(pids(tmp_path)) == 1


@pytest.mark.parametrize("words", [(), ("--always",)])
def test_a_command_is_needed(monkeypatch, capsys, words):
    monkeypatch.setattr(sys, "argv", ["respawn", *words])
    with pytest.raises(SystemExit) as ended:
        respawn.main()
    assert ended.value.code == respawn.WRONG
    assert "usage: respawn [--always] COMMAND" in capsys.readouterr().err


def kept(tmp_path):
    """A keeper in a process of its own, whose command waits."""
    words = (sys.executable, "-c", QUICK, *command(tmp_path, "signal.pause()"))
    process = subprocess.Popen(words, env=with_paths())
    wait_until(lambda: pids(tmp_path))
    return process


def with_paths():
    """The environment, in which a process finds what this one finds."""
    return {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}


def is_alive(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


@pytest.mark.parametrize(
    "number", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL], ids=lambda number: number.name
)
def test_who_is_asked_to_end_or_killed_ends_with_what_it_keeps(tmp_path, number):
    process = kept(tmp_path)
    process.send_signal(number)
    process.wait(PATIENCE)
    (child,) = pids(tmp_path)
    wait_until(lambda: not is_alive(child))


def test_a_crash_of_what_is_kept_does_not_end_the_keeper(tmp_path):
    process = kept(tmp_path)
    os.kill(pids(tmp_path)[0], signal.SIGKILL)
    wait_until(lambda: len(pids(tmp_path)) == 2)
    assert process.poll() is None
    process.send_signal(signal.SIGINT)
    process.wait(PATIENCE)


@pytest.mark.parametrize(
    "waits", ["signal.pause()", "[signal.signal(n, lambda *_: 0) for n in (2, 15)]"]
)
def test_what_is_respawned_ends_when_the_parent_of_the_respawner_is_killed(tmp_path, waits):
    program = "from rst_control.host import respawn; respawn.PATIENCE = 0.2; respawn.main()"
    words = command(tmp_path, f"{waits}\nwhile True: signal.pause()")
    starter = f"import subprocess; subprocess.run({(sys.executable, '-c', program, *words)!r})"
    process = subprocess.Popen((sys.executable, "-c", starter), env=with_paths())
    wait_until(lambda: pids(tmp_path))
    process.kill()
    process.wait(PATIENCE)
    (child,) = pids(tmp_path)
    wait_until(lambda: not is_alive(child))


def test_what_cannot_be_started_is_named_and_not_tried_again(tmp_path, capfd):
    assert respawn.Respawner((str(tmp_path / "nothing"), "x")).run() == respawn.WRONG
    assert "nothing cannot be started: No such file or directory" in capfd.readouterr().err

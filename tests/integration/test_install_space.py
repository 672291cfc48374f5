# SPDX-License-Identifier: BSD-3-Clause
"""The installed packages run without their sources, and without what lies under ~/.local."""

import os
import signal
import subprocess
from pathlib import Path

import numpy as np
import pytest
import soundfile

from support.documents.release import version
from support.launched_system import free_port
from support.process_groups import end_group
from support.theatre_sound import RATE, speak
from support.waiting import wait_until

ROOT = Path(__file__).resolve().parents[2]
PATIENCE = 240.0  # [s] for the system to come up and take a command on a loaded machine
REPEATS, PAUSE = 30, 3.0  # times that "hey robot" is said, and [s] of silence before each

pytestmark = [pytest.mark.slow, pytest.mark.timeout(900)]


@pytest.fixture(scope="module")
def home(install_space):
    """A home folder whose ~/.local has a broken package."""
    return install_space.home


@pytest.fixture(scope="module")
def bare(install_space):
    """The environment of a fresh login, on a master of its own."""
    return {**install_space.environment, "ROS_MASTER_URI": f"http://127.0.0.1:{free_port()}"}


@pytest.fixture(scope="module")
def prefix(install_space):
    """An install space whose sources are gone."""
    install_space.finish()
    return install_space.prefix


@pytest.fixture
def run(prefix, bare):
    """Runs a command in the shell of someone who sourced the install space."""

    def run(*words):
        line = ["/bin/sh", "-c", f'. {prefix}/setup.sh && exec "$@"', "sh", *words]
        done = subprocess.run(line, env=bare, capture_output=True, text=True, check=False)
        return done.stdout + done.stderr

    return run


@pytest.fixture
def system(prefix, bare, tmp_path):
    """The launched system, to whose voice node "hey robot" is said again and again."""
    words = speak("hey robot", "en-us+f2", 150)
    part = np.concatenate([np.zeros(round(PAUSE * RATE), np.float32), words])
    soundfile.write(tmp_path / "said.wav", np.tile(part, REPEATS), RATE)
    launch = "roslaunch voice_assist system.launch source:=wav alarm_sound:=false"
    with (tmp_path / "log.txt").open("wb") as log:
        process = subprocess.Popen(
            ["/bin/bash", "-c", f". {prefix}/setup.bash; exec {launch} wav:={tmp_path}/said.wav"],
            env={**bare, "PYTHONUNBUFFERED": "1"},  # the test reads what it prints meanwhile
            stdout=log,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        yield process, tmp_path / "log.txt"
        end_group(process)


def test_files_are_installed_not_links_to_them(prefix):
    assert (prefix / "share/voice_assist/launch/system.launch").is_file()
    assert (prefix / "share/rst_control/urdf/gen3_openrst.urdf").is_file()
    assert (prefix / "share/session_log/LICENSE").is_file()
    assert not [path for path in prefix.rglob("*") if path.is_symlink()]


def test_every_module_of_the_sources_is_installed(prefix):
    installed = prefix / "lib" / "python3" / "dist-packages"
    for sources in (ROOT / "catkin_ws" / "src").glob("*/src"):
        for module in sources.rglob("*.py"):
            assert (installed / module.relative_to(sources)).is_file()


def test_the_installed_commands_name_their_version(run):
    assert (
        run("rosrun", "voice_assist", "voice_assist", "--version") == f"voice_assist {version()}\n"
    )
    assert run("rosrun", "session_log", "session_log", "--version") == f"session_log {version()}\n"


def test_packages_under_local_are_not_seen(run, home, bare):
    assert "3." in run("python3", "-c", "import em; print(em.__version__)")
    open_to_all = ["python3", "-c", "import em"]
    done = subprocess.run(open_to_all, env=bare, capture_output=True, text=True, check=False)
    assert "under ~/.local" in done.stderr, "the broken one is where Python looks"


def test_the_system_takes_a_command_without_its_sources(run, system, home):
    process, log = system

    def is_active():
        assert process.poll() is None, log.read_text()
        return "hey robot: ready" in log.read_text(encoding="utf-8")

    wait_until(is_active, "an active robot", PATIENCE, every=0.5)
    call = ("rosservice", "call", "/rst_control/command", "command: 'tense'")
    # On a slow machine a halt may come first; the next "hey robot" clears it
    wait_until(lambda: "accepted: True" in run(*call), "a command taken", PATIENCE, every=0.5)
    os.kill(process.pid, signal.SIGINT)
    assert process.wait(PATIENCE) == 0
    shown = log.read_text(encoding="utf-8")
    assert "Traceback" not in shown and "process has died" not in shown, shown
    (session,) = (home / "sessions").glob("*/session.mcap")
    assert "complete" in run("rosrun", "session_log", "session_log", "info", str(session))

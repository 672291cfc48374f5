# SPDX-License-Identifier: BSD-3-Clause
"""Ctrl-C while something comes up ends what was started so far."""

import pytest

from demo import virtual_microphone
from support import launched_system
from support.process_groups import start_group

SLEEP = ["sleep", "600"]


@pytest.fixture
def started(monkeypatch):
    """What was started; each program is one that only waits."""
    processes = []

    def start(command, **options):
        processes.append(start_group(SLEEP))
        return processes[-1]

    monkeypatch.setattr(launched_system, "start_group", start)
    monkeypatch.setattr(virtual_microphone, "start_group", start)
    yield processes
    for process in processes:
        process.kill()
        process.wait()


def interrupted(*_):
    raise KeyboardInterrupt


def test_roscore(started, monkeypatch, tmp_path):
    for name in ("ROS_IP", "ROS_MASTER_URI", "ROS_LOG_DIR"):
        monkeypatch.setenv(name, "")  # so that each is set back
    monkeypatch.setattr(launched_system, "_is_up", interrupted)
    with pytest.raises(KeyboardInterrupt), launched_system.System(tmp_path / "log", {}):
        pass
    assert [process.poll() is not None for process in started] == [True]


def test_the_virtual_microphone(started, monkeypatch):
    monkeypatch.setattr(virtual_microphone.shutil, "which", lambda program: program)
    monkeypatch.setattr(virtual_microphone.VirtualMicrophone, "_answers", interrupted)
    with pytest.raises(KeyboardInterrupt), virtual_microphone.VirtualMicrophone():
        pass
    assert [process.poll() is not None for process in started] == [True]

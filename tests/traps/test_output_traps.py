# SPDX-License-Identifier: BSD-3-Clause
"""Where output of the commands goes: a full disk, a reader that has gone, a terminal of ASCII."""

import os
import subprocess
import sys

import pytest

from session_log.mcap_file.writer import SessionWriter
from session_log.types import Message, MessageSource
from voice_assist.audio.sound_file import read_sound
from voice_assist.errors import AudioError

COMMANDS = [
    ["voice_assist.cli.main", "phrases"],
    ["session_log.cli", "info", "{}"],
]


EMPTY = MessageSource("/t", "std_msgs/Empty", "d41d8cd98f00b204e9800998ecf8427e", "", "/w")


@pytest.fixture(scope="module")
def session(tmp_path_factory):
    path = tmp_path_factory.mktemp("session") / "session.mcap"
    with SessionWriter(path) as writer:
        writer.add(Message(EMPTY, b"", 1_795_200_000 * 10**9, 1))
    return path


def run(command, session, out, **environment):
    words = [word.format(session) for word in command]
    return subprocess.run(
        [sys.executable, "-m", *words],
        stdout=out,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, **environment},
        check=False,
    )


@pytest.mark.parametrize("command", COMMANDS, ids=lambda words: words[0])
def test_a_full_disk_under_the_output_is_one_line(command, session):
    with open("/dev/full", "w") as full:  # noqa: PTH123
        done = run(command, session, full)
    assert done.returncode != 0
    assert done.stderr.splitlines()[-1].endswith("the output: No space left on device")
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize("command", COMMANDS, ids=lambda words: words[0])
def test_a_reader_that_has_gone_is_no_fault(command, session):
    read, write = os.pipe()
    os.close(read)
    with os.fdopen(write, "w") as gone:
        done = run(command, session, gone)
    assert done.stderr == ""


@pytest.mark.parametrize("command", COMMANDS, ids=lambda words: words[0])
def test_a_terminal_that_knows_only_ascii_loses_no_command(command, session):
    ascii_only = {"LC_ALL": "POSIX", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
    done = run(command, session, subprocess.PIPE, **ascii_only, PYTHONIOENCODING="")
    assert done.returncode == 0 and done.stdout


def test_a_folder_in_the_place_of_a_sound_is_not_said_to_be_missing(tmp_path):
    with pytest.raises(AudioError, match=r": not a file$"):
        read_sound(tmp_path)


def test_a_demo_whose_folder_cannot_be_made_says_so_and_starts_nothing(tmp_path):
    (tmp_path / "file").touch()
    done = run(["demo", "--out", "{}/session"], tmp_path / "file", subprocess.PIPE)
    assert done.returncode == 2 and done.stderr == ""
    assert done.stdout.startswith("The folder of the session cannot be made")

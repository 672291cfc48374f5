# SPDX-License-Identifier: BSD-3-Clause
"""Both command lines complete their verbs in bash, and say which shells they know."""

import argparse
import os
import subprocess
import sys

import pytest

from session_log.cli import main as session_log
from typed_config import ConfigError, check_writable, count_option, number_option, run_command
from voice_assist.cli.main import main as voice_assist

PROGRAMS = {"voice_assist": (voice_assist, "evaluate"), "session_log": (session_log, "replay")}


def script(name, capsys):
    with pytest.raises(SystemExit) as ended:
        PROGRAMS[name][0](["--print-completion", "bash"])
    assert ended.value.code == 0
    return capsys.readouterr().out


@pytest.mark.parametrize("name", PROGRAMS)
def test_bash_completes_the_verbs_of_the_command(name, capsys):
    words = f"""
    COMP_WORDS=({name} ''); COMP_CWORD=1; COMP_TYPE=9
    eval "$(complete -p {name} | sed 's/.*-F \\([^ ]*\\).*/\\1/') {name} '' {name}"
    printf '%s\\n' "${{COMPREPLY[@]}}"
    """
    done = subprocess.run(
        ["bash", "--noprofile", "--norc"],
        input=script(name, capsys) + words,
        capture_output=True,
        text=True,
        check=True,
    )
    assert PROGRAMS[name][1] in done.stdout.split(), done.stdout + done.stderr


@pytest.mark.parametrize("name", PROGRAMS)
def test_another_shell_is_refused_with_those_that_are_known(name, capsys):
    with pytest.raises(SystemExit) as ended:
        PROGRAMS[name][0](["--print-completion", "fish"])
    assert ended.value.code == 2
    assert "fish" in (shown := capsys.readouterr().err) and "bash" in shown


@pytest.mark.parametrize("words", ["-1", "4", "nan", "inf", "x"])
def test_a_number_out_of_its_bounds_is_refused_with_them(words):
    with pytest.raises(argparse.ArgumentTypeError, match=f"{words!r}, allowed: 0 to 3 s"):
        number_option(0.0, 3.0, "s")(words)
    assert number_option(0.0, 3.0, "s")("2.5") == 2.5


@pytest.mark.parametrize("words", ["0", "-1", "1.5", "", "²"])
def test_a_count_is_a_whole_number_from_1(words):
    with pytest.raises(argparse.ArgumentTypeError, match="allowed: a whole number from 1"):
        count_option(words)
    assert count_option("12") == 12


def raising(error):
    def act():
        raise error

    return act


@pytest.mark.parametrize(
    ("action", "status", "words"),
    [
        (lambda: None, 0, ""),
        (lambda: 3, 3, ""),
        (raising(ConfigError("rate", 0, "1 to 9")), 7, "name: rate is 0, allowed: 1 to 9\n"),
        (raising(KeyboardInterrupt()), 130, ""),
    ],
)
def test_a_command_ends_with_a_status_and_in_one_line(action, status, words, capsys):
    assert run_command(action, "name", (ConfigError,), failed=7) == status
    assert capsys.readouterr().err == words


def test_an_error_that_nobody_foresaw_keeps_its_traceback():
    with pytest.raises(ArithmeticError):
        run_command(raising(ArithmeticError()), "name", (ConfigError,), failed=7)


PATHS = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}


def program_of(act):
    """A command line that does `act`."""
    program = (
        "import sys; from typed_config import run_command; "
        f"sys.exit(run_command(lambda: {act}, 'name', (), failed=7))"
    )
    return sys.executable, "-c", program


@pytest.mark.parametrize("act", ["print('x' * 100_000)", "sys.exit(print('x' * 100))"])
@pytest.mark.parametrize(
    ("output", "words"),
    [("/dev/full", "name: the output: No space left on device\n"), (None, "")],
)
def test_output_that_cannot_be_written_is_said_and_that_nobody_reads_is_not(output, words, act):
    program = program_of(act)
    if output:
        sink = os.open(output, os.O_WRONLY)
    else:
        reading, sink = os.pipe()
        os.close(reading)  # before it is written to
    command = subprocess.Popen(program, stdout=sink, stderr=subprocess.PIPE, text=True, env=PATHS)
    os.close(sink)
    with command:
        assert command.stderr.read() == words
    assert command.returncode == 7


@pytest.mark.parametrize("act", ["print('x')", "sys.exit(print('x'))"])
def test_a_closed_output_is_a_quiet_end(act):
    closed = ("bash", "-c", 'exec "$@" >&-', "bash", *program_of(act))
    done = subprocess.run(closed, stderr=subprocess.PIPE, env=PATHS)
    assert (done.returncode, done.stderr) == (0, b"")


def test_a_letter_that_the_output_lacks_is_written_by_its_number():
    ascii_only = {**PATHS, "PYTHONIOENCODING": "ascii"}
    assert subprocess.check_output(program_of("print('\u505c')"), env=ascii_only) == b"\\u505c\n"


@pytest.mark.parametrize(
    ("module", "status"), [("voice_assist.cli.main", 2), ("session_log.cli", 1)]
)
def test_a_version_that_cannot_be_written_is_said(module, status):
    words = (sys.executable, "-m", module, "--version")
    with open("/dev/full", "w") as full:  # noqa: PTH123 - a device
        done = subprocess.run(words, stdout=full, stderr=subprocess.PIPE, text=True, env=PATHS)
    assert done.returncode == status and done.stderr.count("\n") == 1
    assert done.stderr.endswith(": the output: No space left on device\n")


def test_a_place_to_write_is_tried_and_left_as_it_was(tmp_path):
    check_writable(tmp_path / "new" / "out.json")
    assert list((tmp_path / "new").iterdir()) == []
    (tmp_path / "kept").write_text("kept", encoding="utf-8")
    check_writable(tmp_path / "kept")
    assert (tmp_path / "kept").read_text("utf-8") == "kept"
    with pytest.raises(NotADirectoryError):
        check_writable(tmp_path / "kept" / "out.json")

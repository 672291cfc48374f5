# SPDX-License-Identifier: BSD-3-Clause
"""Launch lines of the documents, given to a shell and read as roslaunch does, do as they say."""

import json
import os
import re
import shlex
import shutil
import subprocess
from pathlib import Path
from unittest.mock import patch

import pytest
import yaml
from roslaunch import RLException

from support.launched_system import free_port
from tests.launch.argument_places import ROOT, parameters, rows, unmet
from tests.support.doc_lines import PAGES, all_lines
from tests.support.launch_reading import commands_here, dumped, read, restored

PROGRAMS = Path(__file__).parent / "programs"  # where `roslaunch` reads and starts nothing
CONFIG = ROOT / "catkin_ws/src"
EXPLAINS, OTHERS = "--ros-args", "kortex_driver"
NOT_OURS = {"format", "cyclic_data_publish_rate"}  # of audio_capture and kortex_driver
ROWS = {(row.file, row.name): row for row in rows()}
COMPOSE = yaml.safe_load((ROOT / "docker/compose.yaml").read_text(encoding="utf-8"))
NEEDS_MORE = "roslaunch voice_assist kinova.launch"  # of compose.yaml: the trocar is the user's


def launch_lines():
    """Those of documents and container, each once."""
    found = [line.text for line in all_lines() if line.program == "roslaunch"]
    found += [service["command"] for service in COMPOSE["services"].values()]
    ours = [line for line in found if "roslaunch" in line and EXPLAINS not in line]
    return sorted({line for line in ours if OTHERS not in line})


A_LINE_OF_EACH = {  # launch file, whose check of its arguments is its own
    re.findall(r"\w+\.launch", line)[0]: line for line in launch_lines() if ":=" in line
}


@pytest.fixture(scope="module")
def shell(tmp_path_factory):
    """Gives a line to a shell in a checkout that has the files of the user's own as well."""
    folder = tmp_path_factory.mktemp("checkout")
    for name in ("launch", "catkin_ws", "examples"):
        (folder / name).symlink_to(ROOT / name)
    shutil.copytree(CONFIG / "voice_assist/config", folder / "my_voice")
    for mine, ours in (("my_limits", "kinova_limits"), ("my_scene", "scene")):
        shutil.copy(CONFIG / f"rst_control/config/{ours}.yaml", folder / f"{mine}.yaml")
    given = {
        **os.environ,
        "PATH": f"{PROGRAMS}:{os.environ['PATH']}",
        "PYTHONPATH": f"{ROOT}:{os.environ['PYTHONPATH']}",
        "ROS_IP": "127.0.0.1",
        "ROS_MASTER_URI": f"http://127.0.0.1:{free_port()}",
    }

    def shell(line, **more):
        """`CHECKED` has the launch files' own checks run, `WORDS` shows what roslaunch is given."""
        environment = {**given, **more}
        done = subprocess.run(
            ["bash", "-c", line], cwd=folder, env=environment, capture_output=True, text=True
        )
        return done.returncode, done.stdout, done.stderr

    shell.folder = folder
    return shell


@pytest.fixture
def roslaunch(shell, monkeypatch):
    """Takes a line as roslaunch of this process: each start of Python takes longer than it."""

    def roslaunch(line, runs_commands=False):
        code, printed, said = shell(line, WORDS="1")
        assert code == 0, said
        words, environment = json.loads(printed)
        monkeypatch.chdir(shell.folder)
        with patch.dict(os.environ, environment, clear=True), commands_here(words):
            return read(words, runs_commands)

    return roslaunch


def given(line, folder):
    """Launch file, namespace and arguments of a line, as the shell would give them."""
    line = line.replace("$(rospack find rst_control)", str(CONFIG / "rst_control"))
    words = shlex.split(line.replace("$PWD", str(folder)))
    namespace = words[0].partition("=")[2] if words[0].startswith("ROS_NAMESPACE") else ""
    (file,) = (Path(word).name for word in words if word.endswith(".launch"))
    return file, f"/{namespace}", dict(word.split(":=", 1) for word in words if ":=" in word)


@pytest.mark.parametrize("line", [line for line in launch_lines() if line != NEEDS_MORE])
def test_a_line_is_read_and_its_arguments_arrive(shell, roslaunch, line):
    reading = restored(dumped(roslaunch(line)))
    file, namespace, pairs = given(line, shell.folder)
    assert reading.nodes and all(name.startswith(namespace) for name in reading.nodes)
    places = {name: parameters(ROWS[file, name]) for name in pairs}
    for name, value in pairs.items():
        others = set().union(*(places[other] for other in pairs if other != name))
        missed = unmet(ROWS[file, name], value, reading, namespace, others)
        assert not [place for place in missed if _is_started(place, reading)], name


def _is_started(place, reading):
    """Whether the settings are those of a node that this line starts; a real robot is none."""
    kind, _, name = str(place).rpartition(" ")
    is_of_part = kind.endswith(".yaml") or name.startswith("/robot/")
    return not is_of_part or f"/{name.split('/')[1]}" in reading.nodes


@pytest.mark.parametrize("line", A_LINE_OF_EACH.values(), ids=A_LINE_OF_EACH)
def test_a_misspelt_argument_of_a_line_is_refused_with_the_one_that_was_meant(
    roslaunch, line, capfd
):
    misspelt, name, wrong = misspelling(line)
    with pytest.raises(RLException):
        roslaunch(wrong, runs_commands=True)
    said = capfd.readouterr().err
    assert f"'{misspelt}'" in said and f"did you mean {name}:= ?" in said


def misspelling(line):
    """An argument as it is written wrongly and rightly, and the line with it."""
    name = line.partition(":=")[0].split()[-1]
    misspelt = name + name[-1]
    return misspelt, name, line.replace(f"{name}:=", f"{misspelt}:=", 1)


def test_roslaunch_that_starts_the_checks_as_programs_finds_the_same(shell, roslaunch):
    """Not in this process."""
    line = A_LINE_OF_EACH["system.launch"]
    code, printed, said = shell(line)
    assert code == 0, said
    assert restored(printed) == restored(dumped(roslaunch(line)))
    misspelt, name, wrong = misspelling(line)
    code, printed, said = shell(wrong, CHECKED="1")
    assert (code, printed) == (1, "")
    assert f"'{misspelt}'" in said and f"did you mean {name}:= ?" in said


def test_the_robots_service_of_the_container_asks_for_the_trocar(shell):
    assert NEEDS_MORE in launch_lines()
    code, _, said = shell(NEEDS_MORE)
    assert code == 1 and "kinova.launch] requires the" in said


def test_every_argument_that_a_page_names_is_one_of_a_launch_file():
    text = "".join((ROOT / page).read_text("utf-8") for page in PAGES)
    text = "".join(line for line in text.splitlines(True) if OTHERS not in line)
    named = set(re.findall(r"(?<!\w)([a-z]\w*):=", text))
    assert named - NOT_OURS <= {name for _, name in ROWS} and named >= NOT_OURS

# SPDX-License-Identifier: BSD-3-Clause
"""What a verb of make runs belongs to this folder, whatever the shell has for ROS.

A copied folder brings the environment and the build of the folder that it was copied from.
"""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PLAIN = {"PATH": "/usr/bin:/bin"}  # without what a make around the tests hands down
SHELL = {"ROS_HOSTNAME": "a.host.that.is.none", "ROS_NAMESPACE": "left", "PYTHONPATH": "/none"}


def make(*words, folder=ROOT, check=True, **given):
    """A run of make with these variables in its environment."""
    line = ["make", "--no-print-directory", *words]
    given = {**PLAIN, **given}
    return subprocess.run(line, cwd=folder, env=given, capture_output=True, text=True, check=check)


def shown(recipe, *words, **given):
    """What a recipe prints."""
    return make("--eval", f"shown: ; {recipe}", "shown", *words, **given).stdout


def test_a_host_name_and_a_namespace_of_the_shell_reach_no_verb():
    said = shown("@$(RUN) env", **{**os.environ, **SHELL})
    found = dict(line.split("=", 1) for line in said.splitlines() if "=" in line)
    assert "ROS_HOSTNAME" not in found and "ROS_NAMESPACE" not in found
    assert found["ROS_IP"] == "127.0.0.1"
    assert "/none" not in found["PYTHONPATH"].split(":")


SWITCHES = ("GUI", "LATEX", "MIC")
NAMES = (*SWITCHES, "DEVICE", "LANGUAGE", "MODE", "MODEL", "OUT", "PREFIX", "ROBOT", "SESSION")
NAMES += ("BRIDGE", "LIMITS", "SCENE", "TORQUES", "TROCAR", "URDF")  # of a check of the robot
NAMES += ("MANIFEST", "NOISE", "ONLY", "SNR", "VOICES")


def test_what_a_verb_takes_is_read_from_the_command_line_alone():
    values = " ".join(f"$({name}) $${name}" for name in NAMES)

    def echoed(*words):
        return shown(f"@echo {values}", *words, **dict.fromkeys(NAMES, "en_GB:en")).split()

    assert echoed() == []
    values_given = {name: "1" if name in SWITCHES else name.lower() for name in NAMES}
    line = [f"{name}={value}" for name, value in values_given.items()]
    assert echoed(*line) == [value for value in values_given.values() for _ in range(2)]


def dry(*words, **more):
    """What a verb of make would run, and what it said, with more in the environment."""
    done = make("--dry-run", *words, check=False, **more)
    return done.returncode, done.stdout, done.stderr


def test_the_seconds_of_a_shell_are_not_those_of_the_fuzzing():
    """Bash has a variable of that name of its own."""
    assert "--seconds '60'" in dry("fuzz", SECONDS="7")[1]
    assert "--seconds '7'" in dry("fuzz", "SECONDS=7")[1]


def test_what_bench_takes_from_the_environment_reaches_it():
    said = shown("@env", JOBS="2", REPETITIONS="3,5")
    assert {"JOBS=2", "REPETITIONS=3,5"} <= set(said.splitlines())


OPTIONS = {
    "GUI": ("demo", "--gui"),
    "MIC": ("demo", "--microphone"),
    "LATEX": ("report", "--latex"),
}


@pytest.mark.parametrize("name", SWITCHES)
def test_of_a_switch_1_alone_means_yes(name):
    verb, option = OPTIONS[name]
    for value, is_on in (("1", True), ("0", False), ("", False)):
        code, shown, said = dry(verb, f"{name}={value}")
        assert code == 0, said
        assert (option in shown) == is_on
    code, shown, said = dry(verb, f"{name}=yes")
    assert (code, shown) == (2, "")
    assert f"{name} is 'yes', allowed: 1 for yes, 0 or nothing for no" in said


def test_where_the_workspace_cannot_be_sourced_nothing_is_run(tmp_path):
    shutil.copy(ROOT / "Makefile", tmp_path)
    words = ["--eval", "shown: ; @$(RUN) touch shown", "shown"]
    done = make(*words, folder=tmp_path, check=False)
    assert done.returncode != 0 and "catkin_ws/devel/setup.sh" in done.stderr
    assert not (tmp_path / "shown").exists()


@pytest.fixture
def copy(tmp_path):
    """A folder that was set up, as far as make sees."""
    shutil.copytree(ROOT / "docker", tmp_path / "docker")
    for file in ("Makefile", *(path.name for path in ROOT.glob("requirements*.txt"))):
        shutil.copy(ROOT / file, tmp_path)
    for file in (*tmp_path.glob("requirements*.txt"), *tmp_path.glob("docker/**/*")):
        os.utime(file, (0, 0))  # older than the stamps
    (tmp_path / ".setup").mkdir()
    for name in (
        "system",
        "python",
        "workspace",
        "dev-system",
        "dev-python",
        "dev-javascript",
        "dev",
        "bench",
    ):
        (tmp_path / ".setup" / name).touch()
    installed_in(tmp_path, tmp_path)
    (tmp_path / "catkin_ws/devel").mkdir(parents=True)
    (tmp_path / "catkin_ws/devel/setup.sh").touch()
    return tmp_path


def built_in(copy, folder):
    """Leave what cmake keeps of a build in a folder."""
    cache = copy / "catkin_ws/build/CMakeCache.txt"
    cache.parent.mkdir(parents=True)
    line = f"CMAKE_HOME_DIRECTORY:INTERNAL={folder}/catkin_ws/src"
    cache.write_text(f"//\n# generated\nA:PATH=/usr\n{line}\nB:STRING=\n", encoding="utf-8")


SHORT = "#!{}/.venv/bin/python3\n# -*- coding: utf-8 -*-\nimport re\n"
LONG = "#!/bin/sh\n'''exec' {}/.venv/bin/python3 \"$0\" \"$@\"\n' '''\n"  # over 127 letters


def installed_in(copy, folder, text=SHORT):
    """Leave the program pip of an environment that was made in a folder."""
    pip = copy / ".venv/bin/pip"
    pip.parent.mkdir(parents=True, exist_ok=True)
    pip.write_text(text.format(folder), encoding="utf-8")


def steps(copy, *words):
    """Steps of set-up that make would take, in their order."""
    done = make("--dry-run", *(words or ["setup"]), folder=copy)
    begin, lines = "docker/setup.sh ", done.stdout.splitlines()
    return [line.removeprefix(begin) for line in lines if line.startswith(begin)]


WORKSPACE, PYTHON = "workspace", "python requirements.txt"
OTHERS = ["/elsewhere", "/backup{}", "{}/backup", "{}2"]  # beside the folder's own path


def test_a_folder_that_was_set_up_needs_nothing(copy):
    assert steps(copy) == []
    built_in(copy, copy)
    assert steps(copy) == steps(copy, ".setup/bench") == []


@pytest.mark.parametrize("word", ["TORCH=cpu", "TORCH=cuda", "TORCH=gpu", "WHEELS=/wheels"])
def test_another_build_of_torch_and_a_folder_of_wheels_are_not_passed_over(copy, word):
    assert steps(copy, "setup", word) == [PYTHON, WORKSPACE]
    (copy / ".setup/torch").write_text("cuda\n", encoding="utf-8")
    expected = [] if word == "TORCH=cuda" else [PYTHON, WORKSPACE]
    assert steps(copy, "setup", word) == expected
    assert steps(copy) == steps(copy, "setup", "TORCH=", "WHEELS=") == []


def test_what_was_removed_is_made_again(copy):
    shutil.rmtree(copy / "catkin_ws/devel")
    assert steps(copy) == [WORKSPACE]
    built_in(copy, "/elsewhere")  # copied, too
    assert steps(copy) == [WORKSPACE]
    shutil.rmtree(copy / ".venv")
    assert steps(copy) == [PYTHON, WORKSPACE]


@pytest.mark.parametrize("other", OTHERS)
def test_the_build_of_another_folder_is_made_anew(copy, other):
    built_in(copy, other.format(copy))
    assert steps(copy) == [WORKSPACE]


@pytest.mark.parametrize("text", [SHORT, LONG], ids=["short", "long"])
@pytest.mark.parametrize("other", OTHERS)
def test_the_environment_of_another_folder_is_made_anew_and_all_that_follows(copy, other, text):
    built_in(copy, copy)
    installed_in(copy, other.format(copy), text)
    assert steps(copy) == [PYTHON, WORKSPACE]
    more = ["python requirements-dev.txt", "python requirements-bench.txt"]
    assert steps(copy, ".setup/bench") == [PYTHON, WORKSPACE, *more]


def test_in_a_long_path_an_environment_is_its_own_too(copy):
    installed_in(copy, copy, LONG)
    assert steps(copy) == []


def test_an_environment_that_the_user_linked_stays(copy, tmp_path_factory):
    shared = tmp_path_factory.mktemp("shared")
    installed_in(shared, "/elsewhere")
    shutil.rmtree(copy / ".venv")
    (copy / ".venv").symlink_to(shared / ".venv")
    assert steps(copy) == []


INTERRUPTED = """#!/bin/sh
echo "CMAKE_HOME_DIRECTORY:INTERNAL=$PWD/catkin_ws/src" >catkin_ws/build/CMakeCache.txt
exit 1
"""


def test_a_step_that_is_interrupted_is_taken_again(copy):
    built_in(copy, "/elsewhere")
    (copy / "docker/setup.sh").write_text(INTERRUPTED, encoding="utf-8")
    os.utime(copy / "docker/setup.sh", (0, 0))
    assert make("setup", folder=copy, check=False).returncode != 0
    assert steps(copy) == [WORKSPACE]


VENV = """#!/bin/sh
[ "$3" != install ] || [ ! -e no-network ] || exit 1
[ "$2" = venv ] || exit 0
mkdir -p .venv/bin
echo "#!$PWD/.venv/bin/python3" >.venv/bin/pip
cp "$0" .venv/bin/python
"""


@pytest.fixture
def packages(copy):
    """Takes the step of Python's packages, with a Python that installs nothing."""
    shutil.rmtree(copy / ".venv")
    root = copy / "root"
    (root / "usr/bin").mkdir(parents=True)
    (root / "etc").mkdir()
    (root / "etc/os-release").write_text('ID=debian\nVERSION_ID="12"\n', encoding="utf-8")
    python = root / "usr/bin/python3"
    python.write_text(VENV, encoding="utf-8")
    python.chmod(0o755)

    def packages(torch="cuda"):
        given = {**PLAIN, "SYSTEM_ROOT": str(root)}
        if torch is not None:
            given["TORCH"] = torch
        words = ["docker/setup.sh", "python", "requirements.txt"]
        subprocess.run(words, cwd=copy, env=given, capture_output=True, check=True)

    packages()
    return packages


@pytest.mark.parametrize("text", [SHORT, LONG], ids=["short", "long"])
def test_set_up_removes_the_environment_of_another_folder(copy, packages, text):
    kept, pip = copy / ".venv/kept", copy / ".venv/bin/pip"
    kept.touch()
    pip.write_text(text.format(copy), encoding="utf-8")
    packages()
    assert kept.exists(), "its own environment stays"
    pip.write_text(text.format("/elsewhere"), encoding="utf-8")
    packages()
    assert not kept.exists()
    assert pip.read_text(encoding="utf-8") == f"#!{copy}/.venv/bin/python3\n"
    assert steps(copy) == []


def test_where_the_packages_cannot_be_fetched_the_old_environment_stays(copy, packages):
    kept, pip = copy / ".venv/kept", copy / ".venv/bin/pip"
    kept.touch()
    pip.write_text(SHORT.format("/elsewhere"), encoding="utf-8")
    (copy / "no-network").touch()
    with pytest.raises(subprocess.CalledProcessError):
        packages()
    assert kept.exists() and "/elsewhere" in pip.read_text(encoding="utf-8")
    assert not (copy / ".venv.old").exists()
    (copy / "no-network").unlink()
    packages()
    assert not kept.exists() and not (copy / ".venv.old").exists()


def test_a_build_of_torch_is_remembered_once_it_is_there(copy, packages):
    chosen = copy / ".setup/torch"
    assert chosen.read_text(encoding="utf-8") == "cuda\n"
    packages(None)
    assert chosen.read_text(encoding="utf-8") == "cuda\n"
    with pytest.raises(subprocess.CalledProcessError):
        packages("gpu")
    (copy / "no-network").touch()
    with pytest.raises(subprocess.CalledProcessError):
        packages("")
    assert chosen.read_text(encoding="utf-8") == "cuda\n"
    (copy / "no-network").unlink()
    packages("")  # which goes back to the choice by the card
    assert chosen.read_text(encoding="utf-8") == "\n"

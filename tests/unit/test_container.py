# SPDX-License-Identifier: BSD-3-Clause
"""The image's files: what they copy, call and launch is there. No container is started."""

import ast
import os
import shutil
import subprocess
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]
COMPOSE = yaml.safe_load((ROOT / "docker/compose.yaml").read_text(encoding="utf-8"))
DOCKERFILE = (ROOT / "docker/Dockerfile").read_text(encoding="utf-8")
SESSIONS = "../sessions:/voice_assist/sessions"


@pytest.mark.parametrize("name", COMPOSE["services"])
def test_each_service_keeps_its_sessions_and_its_command_is_there(name):
    service = COMPOSE["services"][name]
    assert SESSIONS in service["volumes"]
    program, *words = service["command"].split()
    assert program in ("make", "roslaunch")
    if program == "roslaunch":
        package, file, *given = words
        launch = ROOT / "catkin_ws/src" / package / "launch" / file
        declared = {arg.get("name") for arg in ET.parse(launch).getroot().findall("arg")}
        assert {word.partition(":=")[0] for word in given} <= declared


def test_the_robots_network_real_time_sound_screen_pedal_and_card_have_a_profile():
    profiles = {profile for s in COMPOSE["services"].values() for profile in s.get("profiles", [])}
    assert profiles == {"microphone", "screen", "pedal", "gpu", "robot"}
    assert COMPOSE["services"]["robot"]["cap_add"] == ["SYS_NICE"]
    assert COMPOSE["services"]["robot"]["network_mode"] == "host"


def test_what_the_image_copies_and_starts_is_there():
    copied = [line.split()[1:-1] for line in DOCKERFILE.splitlines() if line.startswith("COPY")]
    assert all((ROOT / name).exists() for names in copied for name in names)
    assert os.access(ROOT / "docker/entrypoint.sh", os.X_OK)


def test_a_device_is_read_by_a_groups_number_since_the_image_lacks_the_hosts_groups():
    groups = [group for s in COMPOSE["services"].values() for group in s.get("group_add", [])]
    assert groups == ["${INPUT_GID:-65534}"]


@pytest.mark.parametrize("file", ["docs/test_links.py", "unit/support/test_release.py"])
def test_without_git_as_in_the_image_what_needs_it_is_skipped(file):
    tree = ast.parse((ROOT / "tests" / file).read_text(encoding="utf-8"))
    functions = {f.name: f for f in tree.body if isinstance(f, ast.FunctionDef)}
    callers = [name for name, f in functions.items() if "'git'" in ast.unparse(f)]
    callers += [n for n, f in functions.items() if any(f"{c}(" in ast.unparse(f) for c in callers)]
    tests = {name for name in callers if name.startswith("test_")}
    assert tests
    assert all("@needs_git" in ast.unparse(functions[name]) for name in tests)


@pytest.mark.parametrize(
    ("words", "warned"),
    [
        (["roslaunch", "voice_assist", "system.launch"], True),
        (["make", "demo"], True),
        (["make", "paper"], True),
        (["make", "film"], True),
        (["rosrun", "session_log", "recorder"], True),
        (["make", "report"], False),
        (["echo", "x"], False),
    ],
)
def test_sessions_that_go_with_the_container_are_named(tmp_path, words, warned):
    """The entry point, on a folder in the place of the image's."""
    text = (ROOT / "docker/entrypoint.sh").read_text(encoding="utf-8")
    (tmp_path / "entry").write_text(
        text.replace("/voice_assist", str(tmp_path)).replace("exec", "echo")
    )
    (tmp_path / ".commit").write_text("abc\n")
    (tmp_path / "sessions").mkdir()
    (tmp_path / "catkin_ws/devel").mkdir(parents=True)
    (tmp_path / "catkin_ws/devel/setup.bash").touch()
    line = ["/bin/bash", str(tmp_path / "entry"), *words]
    done = subprocess.run(line, capture_output=True, text=True, check=True)
    assert done.stdout.split() == words
    assert ("NOT KEPT" in done.stderr) == warned


BUILDAH = """#!/bin/sh
echo "$*" >>"$CALLS"
case "$1" in
from) echo one ;;
"$FAILS") exit 1 ;;
"$ENDS") kill -TERM "$PPID" ;;
mount) echo "$PWD/docker" ;;
esac
"""


@pytest.fixture
def build(tmp_path):
    """Runs the build without a daemon, with a buildah that notes what it is asked for."""
    (tmp_path / "docker").mkdir()
    (tmp_path / "bin").mkdir()
    shutil.copy(ROOT / "docker/build_without_daemon.sh", tmp_path / "docker")
    for name, text in (("buildah", BUILDAH), ("git", "#!/bin/sh\necho abc\n")):
        (tmp_path / "bin" / name).write_text(text, encoding="utf-8")
        (tmp_path / "bin" / name).chmod(0o755)
    calls = tmp_path / "calls"

    def build(*words, fails="none", ends="none"):
        given = {"PATH": f"{tmp_path}/bin:/usr/bin:/bin", "CALLS": str(calls)}
        given |= {"FAILS": fails, "ENDS": ends}
        line = ["docker/build_without_daemon.sh", *words]
        done = subprocess.run(
            line, cwd=tmp_path, env=given, capture_output=True, text=True, check=False
        )
        return done.returncode, done.stdout, calls.read_text(encoding="utf-8").splitlines()

    return build


def test_a_build_without_a_daemon_ends_with_the_size_and_keeps_no_container(build):
    code, printed, calls = build()
    assert (code, printed) == (0, "0 MB\n") and calls[-1] == "rm one"


def test_an_image_that_cannot_be_mounted_fails_and_keeps_no_container(build):
    code, printed, calls = build(fails="mount")
    assert (code, printed) == (1, "") and calls[-1] == "rm one"


@pytest.mark.parametrize("failed", [True, False])
def test_a_command_in_the_image_that_is_ended_keeps_no_container(build, failed):
    code, _, calls = build("run", "make", "demo", **{"fails" if failed else "ends": "run"})
    assert code == (1 if failed else 130) and calls[-1] == "rm one"

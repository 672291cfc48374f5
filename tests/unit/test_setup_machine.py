# SPDX-License-Identifier: BSD-3-Clause
"""Set-up refuses a machine it cannot serve in one line, before anything is installed or written."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
DEBIAN_12 = 'PRETTY_NAME="Debian GNU/Linux 12 (bookworm)"\nVERSION_ID="12"\nID=debian\n'
OTHERS = {
    "ubuntu 24.04": 'NAME="Ubuntu"\nVERSION_ID="24.04"\nID=ubuntu\nID_LIKE=debian\n',
    "ubuntu 20.04": 'VERSION_ID="20.04"\nVERSION="20.04.6 LTS (Focal Fossa)"\nID=ubuntu\n',
    "debian 13": 'VERSION_ID="13"\nID=debian\n',
    "debian 11": 'VERSION_ID="11"\nID=debian\n',
    "debian 120": 'VERSION_ID="120"\nID=debian\n',
    "debian ": "ID=debian\n",  # testing and unstable have no number
    "raspbian 12": 'ID=raspbian\nVERSION_ID="12"\n',
    "fedora 43": "ID=fedora\nVERSION_ID=43\n",
}
TOUCHED = "touched"


def program(file, text):
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(f"#!/bin/sh\n{text}\n", encoding="utf-8")
    file.chmod(0o755)


@pytest.fixture
def machine(tmp_path):
    """A copy of what set-up needs, on a machine whose system, processor and Python are made up."""

    def make(release=DEBIAN_12, architecture="amd64", python=None, folder="copy"):
        etc = tmp_path / "root" / "etc"
        etc.mkdir(parents=True)
        if release:
            (etc / "os-release").write_text(release, encoding="utf-8")
        if python:
            works = "0" if python.startswith("3.11.") else "1"
            answer = f'[ "$1" = --version ] && echo Python {python} || exit {works}'
            program(tmp_path / "root/usr/bin/python3", answer)
        tools = tmp_path / "tools"
        program(tools / "dpkg", f"echo {architecture}")
        for name in ("apt-get", "dpkg-query", "sudo", "catkin_make"):
            program(tools / name, f'echo {name} "$@" >>{tmp_path}/{TOUCHED}; exit 1')
        copy = tmp_path / folder
        copy.mkdir()
        shutil.copytree(ROOT / "docker", copy / "docker")
        for file in ("Makefile", *(path.name for path in ROOT.glob("requirements*.txt"))):
            shutil.copy(ROOT / file, copy)
        return copy

    return make


def run(copy, *words, programs="/usr/bin:/bin"):
    """Exit status and what was printed, of a command in the copy on the made-up machine."""
    top = copy.parent
    environment = {
        "PATH": f"{top}/tools:{programs}",
        "SYSTEM_ROOT": str(top / "root"),
        "LANG": "C.UTF-8",
    }
    done = subprocess.run(
        list(words), cwd=copy, env=environment, capture_output=True, text=True, check=False
    )
    return done.returncode, done.stdout + done.stderr


def assert_refused(copy, *names, words=("make", "setup")):
    """It is said in one line, and nothing else has happened."""
    before = sorted(copy.rglob("*"))
    status, printed = run(copy, *words)
    assert status != 0
    (line,) = [line for line in printed.splitlines() if not line.startswith("make")]
    assert all(name in line for name in names), line
    assert "docker build -f docker/Dockerfile" in line
    assert sorted(copy.rglob("*")) == before
    assert not (copy.parent / TOUCHED).exists()


@pytest.mark.parametrize("name", OTHERS)
def test_another_system_is_refused_before_anything_is_installed(machine, name):
    assert_refused(machine(release=OTHERS[name]), f"this is {name}")


@pytest.mark.parametrize("part", ["workspace", "check"])
def test_each_part_of_set_up_says_the_same(machine, part):
    copy = machine(release=OTHERS["debian 11"])
    assert_refused(copy, "this is debian 11", words=("docker/setup.sh", part))


def test_a_system_without_os_release_is_refused(machine):
    assert_refused(machine(release=None), "a system without /etc/os-release")


@pytest.mark.parametrize("architecture", ["arm64", "i386", "armhf"])
def test_another_processor_is_refused(machine, architecture):
    assert_refused(machine(architecture=architecture), "x86-64", architecture, "linux/amd64")


def test_another_python_in_place_of_debians_is_refused(machine):
    assert_refused(machine(python="3.12.3"), "Python 3.12.3", "3.11")


@pytest.mark.parametrize(
    "folder", ["a b", "o'brien", 'say "hi"', "a:b", "a;b", "$HOME", "a#b", "é"]
)
def test_a_path_that_ros_takes_apart_is_refused(machine, folder):
    assert_refused(machine(folder=folder), "path", folder)


@pytest.mark.parametrize("python", ["3.11.2", None])
def test_debian_12_is_taken_with_its_python_or_none_yet(machine, python):
    copy = machine(python=python)
    assert run(copy, "docker/setup.sh", "check") == (0, "")
    status, _ = run(copy, "docker/setup.sh", "system")
    assert status != 0, "the made-up apt-get fails"
    assert "apt-get update" in (copy.parent / TOUCHED).read_text(encoding="utf-8")


@pytest.mark.parametrize("folder", ["a-b_c.d+e", "@work", "~tmp", "a=1,b"])
def test_other_paths_are_taken(machine, folder):
    assert run(machine(folder=folder), "docker/setup.sh", "check") == (0, "")


@pytest.mark.parametrize("prefix", ["/opt/a b", "/opt/o'brien"])
def test_an_install_space_gets_a_plain_path_too(machine, prefix):
    status, printed = run(machine(), "docker/setup.sh", "install", prefix)
    assert status == 1
    assert prefix in printed and len(printed.splitlines()) == 1


@pytest.mark.parametrize("prefix", ["/proc/x", "{}/file", "{}/file/x"])
def test_a_prefix_that_cannot_be_written_is_refused_before_the_build(machine, tmp_path, prefix):
    (tmp_path / "file").touch()
    copy, prefix = machine(), prefix.format(tmp_path)
    words = f"PREFIX is '{prefix}', allowed: a folder that can be made and written\n"
    assert run(copy, "docker/setup.sh", "install", prefix) == (1, words)
    assert not (tmp_path / TOUCHED).exists() and not (copy / ".setup").exists()


def test_readers_in_javascript_are_installed_by_their_lock(machine):
    copy = machine()
    program(copy.parent / "tools/npm", f'echo "$@" >>{copy.parent}/{TOUCHED}')
    assert run(copy, "docker/setup.sh", "javascript") == (0, "")
    said = (copy.parent / TOUCHED).read_text(encoding="utf-8")
    assert said.startswith("ci --prefix .setup/node ")
    lock = "docker/javascript/package-lock.json"
    assert (copy / ".setup/node/package-lock.json").read_bytes() == (ROOT / lock).read_bytes()


def test_without_npm_the_tests_that_need_it_are_named_and_set_up_goes_on(machine, tmp_path):
    copy, programs = machine(), tmp_path / "without npm"
    programs.mkdir()
    for name in ("sh", "dirname"):
        (programs / name).symlink_to(shutil.which(name))
    status, printed = run(copy, "docker/setup.sh", "javascript", programs=programs)
    assert status == 0
    assert "npm is missing" in printed and "skipped" in printed and "install nodejs" in printed
    assert not (copy / ".setup").exists()


def test_this_machine_is_taken():
    environment = {key: os.environ[key] for key in ("PATH",)}
    subprocess.run([str(ROOT / "docker/setup.sh"), "check"], env=environment, check=True)

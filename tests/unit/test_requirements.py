# SPDX-License-Identifier: BSD-3-Clause
"""What users install is all that the product imports, and what tests need is kept apart."""

import importlib.util
import os
import re
import shutil
import subprocess
from functools import cache
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PRODUCT = ("catkin_ws/src", "demo", "support")
# Each has a file; the part that needs it says what to install
OPTIONAL = {"pyarrow", "foxglove-sdk", "imageio-ffmpeg"}
# Files or needs of others; ruckig's module is in no list of importlib.metadata.
NOT_IMPORTED = {"openwakeword", "silero-vad", "tiktoken", "more-itertools", "tqdm", "ruckig"}

# A line of prose that begins so names no distribution
IMPORT = re.compile(r"^\s*(?:import|from)\s+([A-Za-z_]\w*)", re.MULTILINE)


def named(file):
    """Distributions that a requirements file names."""
    lines = (ROOT / file).read_text(encoding="utf-8").splitlines()
    return {m[1].lower() for line in lines if (m := re.match(r"([\w.-]+)==", line))}


@cache
def imported(*folders):
    """Distributions of the Python environment that the code of these folders imports."""
    found = packages_distributions()
    files = [path for folder in folders for path in (ROOT / folder).rglob("*.py")]
    modules = {name for file in files for name in IMPORT.findall(file.read_text("utf-8"))}
    return {found[m][0].lower() for m in modules if m in found and not is_debians(m)}


def is_debians(module):
    """Whether ROS or Debian brings it."""
    return any((Path("/usr/lib/python3/dist-packages") / module).glob("*.py"))


def test_users_install_what_the_product_imports():
    needed = imported(*PRODUCT)
    assert needed - named("requirements.txt") - {"pyyaml", "setuptools"} == OPTIONAL


def test_users_install_nothing_that_the_product_does_not_need():
    needed = imported(*PRODUCT) | NOT_IMPORTED | {"pyyaml"}
    assert named("requirements.txt") - needed == set()


@pytest.mark.parametrize(
    "file", ["requirements-dev.txt", "requirements-parquet.txt", "requirements-foxglove.txt"]
)
def test_no_package_is_pinned_in_two_files(file):
    assert not named(file) & named("requirements.txt")


def test_packages_of_debian_are_listed_once():
    lists = [ROOT / "docker" / name for name in ("apt-packages.txt", "apt-packages-dev.txt")]
    names = [line for file in lists for line in file.read_text().split("\n") if line[:1] not in "#"]
    assert len(names) == len(set(names))


@pytest.fixture
def lock(tmp_path, monkeypatch):
    """The maker of the lock, on a copy of it that may be changed: (module, change)."""
    spec = importlib.util.spec_from_file_location("lock", ROOT / "docker" / "lock.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    text = module.LOCK.read_text(encoding="utf-8")
    monkeypatch.setattr(module, "LOCK", tmp_path / "constraints.txt")

    def change(old="", new=""):
        assert old in text
        module.LOCK.write_text(text.replace(old, new) if old else text, encoding="utf-8")
        return module.check()

    return change


def test_every_package_is_locked_with_its_digest(lock):
    assert lock() == []


@pytest.mark.parametrize(
    ("old", "new", "word"),
    [
        ("\nrich==15.0.0 ", "\nrich==14.0.0 ", "pins rich==15.0.0, locked: ['14.0.0']"),
        ("\nnumba==0.68.1 ", "\n# ", "pins numba==0.68.1, locked: []"),
        (
            "\nyarl==1.25.1 --hash=sha256:",
            "\nyarl==1.25.1 --hash=md5:",
            "no pin with a digest: yarl",
        ),
        ("\nyarl==1.25.1 ", "\nyarl>=1.25.1 ", "no pin with a digest: yarl"),
        ("\nyarl==1.25.1 ", "\nyarl==1.0.0 ", "yarl 1.25.1 is installed, locked: ['1.0.0']"),
    ],
)
def test_a_lock_that_is_not_of_the_files_or_the_installed_packages_is_named(lock, old, new, word):
    assert any(word in fault for fault in lock(old, new))


def chosen(tmp_path, file, *, card=False, **environment):
    """Packages that set-up would install from a file, and what it says, without any network."""
    if card:
        (tmp_path / "proc/driver/nvidia").mkdir(parents=True)
        (tmp_path / "proc/driver/nvidia/version").touch()
    done = called(tmp_path, "locked", file, **environment)
    return [line.split()[0] for line in done.stdout.splitlines()], done.stderr


def called(tmp_path, function, *words, **environment):
    """A function of set-up, alone, in a checkout of its own: this one may remember a choice."""
    library = (ROOT / "docker/setup.sh").read_text(encoding="utf-8").partition("\nmachine\n")[0]
    docker = tmp_path / "checkout/docker"
    if not docker.exists():
        docker.mkdir(parents=True)
        shutil.copy(ROOT / "docker/constraints.txt", docker)
        (docker.parent / ".venv").symlink_to(ROOT / ".venv")
    return subprocess.run(
        ["/bin/sh", "-c", f'{library}\n{function} "$@"', str(docker / "x"), *words],
        env={"PATH": os.environ["PATH"], "SYSTEM_ROOT": str(tmp_path), **environment},
        capture_output=True,
        text=True,
        check=False,
    )


CPU, CUDA = "torch==2.13.0+cpu", "torch===2.13.0"


def test_cuda_is_chosen_for_an_nvidia_card_and_by_the_variable(tmp_path):
    for given in ({"TORCH": "cuda"}, {"card": True}):
        packages, _ = chosen(tmp_path, "requirements.txt", **given)
        assert CUDA in packages and CPU not in packages
        assert any(package.startswith("nvidia-cublas") for package in packages)


def test_the_variable_comes_before_the_card(tmp_path):
    packages, said = chosen(tmp_path, "requirements.txt", card=True, TORCH="cpu")
    assert CUDA not in packages and not [p for p in packages if p.startswith("nvidia-")]
    assert CPU in packages or "PIP_EXTRA_INDEX_URL" in said  # if this machine has the CUDA build


def remembered(tmp_path, build):
    """Let an earlier set-up have been called with that build."""
    (tmp_path / "checkout/.setup").mkdir(parents=True, exist_ok=True)
    (tmp_path / "checkout/.setup/torch").write_text(f"{build}\n", encoding="utf-8")


@pytest.mark.parametrize(("build", "card"), [("cpu", True), ("cuda", False)])
def test_a_choice_is_remembered_until_another_is_given(tmp_path, build, card):
    chosen(tmp_path, "requirements.txt", card=card)
    remembered(tmp_path, build)
    other, by_card = {"cpu": "cuda", "cuda": "cpu"}[build], "cuda" if card else "cpu"
    assert called(tmp_path, "torch_wished").stdout == f"{build}\n"
    assert called(tmp_path, "torch_wished", TORCH=other).stdout == f"{other}\n"
    assert called(tmp_path, "torch_wished", TORCH="").stdout == f"{by_card}\n"


def test_a_remembered_cpu_build_that_cannot_be_had_is_not_replaced(tmp_path):
    remembered(tmp_path, "cpu")
    assert called(tmp_path, "torch_wished").stdout == "cpu\n"
    (tmp_path / "checkout/.venv").unlink()  # with the build that is installed
    packages, said = chosen(tmp_path, "requirements.txt")
    assert not packages and "TORCH=cpu, but the package index has no torch" in said


def test_a_folder_of_wheels_comes_before_what_is_remembered(tmp_path):
    (tmp_path / "torch-2.13.0+cpu-cp311-cp311-manylinux_2_28_x86_64.whl").touch()
    remembered(tmp_path, "cuda")
    packages, _ = chosen(tmp_path, "requirements.txt", WHEELS=str(tmp_path))
    assert CPU in packages and CUDA not in packages


def test_another_word_for_the_choice_is_refused(tmp_path):
    packages, said = chosen(tmp_path, "requirements.txt", TORCH="gpu")
    assert not packages and "TORCH=gpu, allowed: cpu, cuda" in said


@pytest.mark.parametrize("card", [False, True])
def test_without_a_network_torch_is_the_build_that_was_fetched(tmp_path, card):
    other, cpu = tmp_path / "cuda", tmp_path / "cpu"
    for folder in (other, cpu):
        folder.mkdir()
    (cpu / "torch-2.13.0+cpu-cp311-cp311-manylinux_2_28_x86_64.whl").touch()
    for folder, build in ((cpu, CPU), (other, CUDA)):
        at = tmp_path / f"machine of {folder.name}"
        packages, _ = chosen(at, "requirements.txt", card=card, WHEELS=str(folder))
        assert [p for p in packages if p.startswith("torch=")] == [build]
    packages, said = chosen(tmp_path, "requirements.txt", WHEELS=str(other), TORCH="cpu")
    assert not packages and f"TORCH=cpu, but {other} has no torch 2.13.0+cpu" in said


def test_wheels_come_from_a_folder_that_is_there(tmp_path):
    assert called(tmp_path, "wheels").stdout == ""
    found = called(tmp_path, "wheels", WHEELS=str(tmp_path))
    assert found.stdout == f"--no-index --find-links {tmp_path}"
    for gone in (tmp_path / "gone", tmp_path / "a folder"):
        refused = called(tmp_path, "wheels", WHEELS=str(gone))
        assert refused.returncode == 1 and refused.stdout == "" and str(gone) in refused.stderr


def test_packages_are_fetched_to_an_absolute_path(tmp_path):
    for folder in ((), ("wheels",)):
        refused = called(tmp_path, "fetch", *folder)
        assert refused.returncode == 1 and "must be an absolute path" in refused.stderr


def test_each_file_has_its_own_packages(tmp_path):
    train, _ = chosen(tmp_path, "requirements-train.txt")
    assert set(map(str.lower, named("requirements-train.txt"))) == {p.split("=")[0] for p in train}

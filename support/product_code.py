# SPDX-License-Identifier: BSD-3-Clause
"""Digests of the code behind a figure, so that an older figure is marked by itself.

One is of the product, one of the bench. They are made of definitions, settings and networks. A file
that moves, a comment or a docstring does not change them; a definition does. Where one differs from
what a result holds, the result is older than the code that it measures, or that measured it.
"""

from __future__ import annotations

import ast
import hashlib
import re
from collections.abc import Sequence
from functools import cache
from pathlib import Path

import yaml

ROOT = Path(__file__).resolve().parent.parent
PACKAGES = ROOT / "catkin_ws" / "src"
SETTINGS, NETWORKS = ".yaml", (".pt", ".npz")
LENGTH = 16  # characters of a digest
BENCH = re.compile(r"(bench|paper|support)(?!\.product_code)(\.\w+)+")  # what measures, by module


def _rooms(package: str, *rooms: str) -> tuple[str, ...]:
    return tuple(f"{package}/{room}" for room in rooms)


CONTROLLER = _rooms(
    "rst_control",
    *("admission", "assembly.py", "commands", "config", "description", "execution", "kernels.py"),
    *("errors.py", "kinematics", "planning", "registration", "robot", "supervision", "tension"),
    *("tissue", "trajectory"),
    *("types.py", "collision.yaml", "controller.yaml", "gen3_openrst.yaml", "limits.yaml"),
    *("rcm.yaml", "scene.yaml"),
)
URDF = ("/catkin_ws/src/rst_control/urdf/gen3_openrst.urdf",)
SIMULATION = (
    *CONTROLLER,
    *_rooms("rst_control", "simulation", "simulator.yaml", "plant.yaml"),
    *URDF,
)
KINOVA = (
    *CONTROLLER,
    *_rooms("rst_control", "kinova", "simulation", "torque_tension.yaml", "kinova_bridge.yaml"),
    *_rooms("rst_control", "kinova_controller.yaml", "kinova_limits.yaml", "kinova_stand_in.yaml"),
    *_rooms("rst_control", "plant.yaml", "simulator.yaml"),
    *URDF,
)
PLANT = (*SIMULATION, *KINOVA, "/launch/kinova_lab.yaml", "/launch/lab.yaml")
SPEAKER = _rooms(
    "voice_assist", "audio", "speaker", "speaker.yaml", "speaker.pt", "speaker_cohort.npz"
)
HEARING = _rooms(  # without a profile
    "voice_assist",
    *("assembly.py", "audio", "config", "intent", "networks.py", "pipeline"),
    *("recognizer", "side_inputs.py", "speaker", "spotter", "text", "types.py", "vad"),
    *("audio.yaml", "commands.yaml", "moving.yaml", "recognizer.yaml", "spotter.yaml"),
    *("embedded.pt", "overlap.pt", "spotter.pt", "verifier.pt"),
)
LANGUAGES = (
    *HEARING,
    *_rooms("voice_assist", "commands_de.yaml", "commands_es.yaml"),
    *_rooms("voice_assist", "commands_fr.yaml", "commands_ja.yaml"),
)
ANSWERS = (*HEARING, *_rooms("voice_assist", "answers", "alarms.yaml"))
ENROLMENT = (*HEARING, *_rooms("voice_assist", "enrolment", "profile", "enrolment.yaml"))
RECORDER = _rooms(  # what runs beside a robot; files are read later
    "session_log",
    *("mcap_file/durable_stream.py", "mcap_file/encoding.py", "mcap_file/headers.py"),
    *("mcap_file/session_folder.py", "mcap_file/writer.py", "recording", "recorder.yaml"),
)
RECORDING = _rooms("session_log", "mcap_file", "recording", "recorder.yaml")
REPORT = (*RECORDING, *_rooms("session_log", "report", "report.yaml"))
NODES = ("typed_config",)  # of all that run nodes: it reads their settings and starts them
VOICE_NODE = (*NODES, *_rooms("voice_assist", "ros"))
DISPLAY = _rooms("voice_assist", "display", "display.yaml")
ROBOT_NODES = (*NODES, *SIMULATION, *_rooms("rst_control", "host", "ros"))
SYSTEM = (
    *(*ROBOT_NODES, *HEARING, *VOICE_NODE, *RECORDER, *DISPLAY, *_rooms("session_log", "ros")),
    *_rooms("voice_assist", "alarms", "answers", "pedal", "alarms.yaml", "pedal.yaml"),
)
TWO_HOSTS = (*SYSTEM, "/launch/two_hosts.yaml")
PAPER = (*SYSTEM, "/demo/overrides.yaml", "/demo/robot_overrides.yaml")
SET_UP = tuple(
    f"/{file}" for file in ("docker/setup.sh", "docker/constraints.txt", "requirements.txt")
)


def beside_hearing(rooms: Sequence[str]) -> str:
    """Digest of rooms without those of hearing; empty: there are no others."""
    others = [room for room in rooms if room not in HEARING]
    return identity(others) if others else ""


def identity(rooms: Sequence[str]) -> str:
    """Digest of rooms.

    Args:
        rooms: Folders and files of packages, such as "rst_control/planning", "rst_control/rcm.yaml"
            (a file of settings) or "voice_assist/spotter.pt" (a network); with a leading "/" a file
            of the repository.

    Raises:
        FileNotFoundError: One is not there, or holds no code.
    """
    found = sorted({one for room in rooms for one in _of_room(room)})
    return _digest("".join(found).encode())


@cache
def _of_room(room: str) -> tuple[str, ...]:
    if room.startswith("/"):
        return (_digest((ROOT / room.removeprefix("/")).read_bytes()),)
    package, _, name = room.partition("/")
    if name.endswith(NETWORKS):
        return (_digest((PACKAGES / package / "models" / name).read_bytes()),)
    if name.endswith(SETTINGS):
        text = (PACKAGES / package / "config" / name).read_text(encoding="utf-8")
        return (_digest(name.encode() + repr(yaml.safe_load(text)).encode()),)
    place = PACKAGES / package / "src" / package / name
    files = [place] if place.is_file() else sorted(place.rglob("*.py"))
    if not files:
        raise FileNotFoundError(f"{place}: no code")
    return tuple(one for file in files for one in _of_file(file))


@cache
def _of_file(file: Path) -> tuple[str, ...]:
    return definitions(file.read_text(encoding="utf-8"))


def bench_identity(module: str) -> str:
    """Digest of a module that measures, and of the modules beside the product that it uses."""
    files, waiting = set[Path](), [module]
    while waiting:
        file = ROOT / f"{waiting.pop().replace('.', '/')}.py"
        if file.is_file() and file not in files:
            files.add(file)
            waiting += _used(file)
    return _digest("".join(sorted(one for file in files for one in _of_file(file))).encode())


@cache
def _used(file: Path) -> tuple[str, ...]:
    """What a module imports or names, as that of another process, where it may be of a bench."""
    found: list[str] = []
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found += [one.name for one in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module:
            found += [node.module, *(f"{node.module}.{one.name}" for one in node.names)]
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            found.append(node.value)
    return tuple(name for name in found if BENCH.fullmatch(name))


def definitions(text: str) -> tuple[str, ...]:
    """Digests of what the lines of a module define, whatever their comments, order and imports."""
    tree = ast.parse(text)
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        if isinstance(body, list):
            body[:] = [line for line in body if not _says_nothing(line)]
    return tuple(_digest(ast.dump(line).encode()) for line in tree.body)


def _says_nothing(line: ast.stmt) -> bool:
    """Imports and docstrings."""
    if isinstance(line, ast.Expr) and isinstance(line.value, ast.Constant):
        return isinstance(line.value.value, str)
    return isinstance(line, ast.Import | ast.ImportFrom)


def _digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()[:LENGTH]

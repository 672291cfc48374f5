# SPDX-License-Identifier: BSD-3-Clause
"""All settings files of the product, the dataclass of each, and every value in them."""

from __future__ import annotations

import contextlib
import copy
import dataclasses
import typing
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import NoneType, UnionType

import pytest
import yaml

from demo.script import Script
from paper.config import ExperimentConfig
from rst_control.config import LimitsConfig, MotionConfig, SimulationConfig
from rst_control.config.crtk import CrtkConfig
from rst_control.config.torque_tension import TorqueTensionConfig
from rst_control.description.facts import RobotFacts
from rst_control.kinova.config import BridgeConfig
from rst_control.kinova.stand_in import StandInConfig
from session_log.config import FoxgloveConfig, RecorderConfig, ReportConfig
from session_log.replay.config import ReplayConfig
from typed_config.fields import RULE, Rule
from voice_assist.config import CommandsConfig, VoiceConfig
from voice_assist.config.alarms import AlarmsConfig
from voice_assist.config.believed import VoiceBelievedConfig
from voice_assist.config.devices import DevicesConfig
from voice_assist.config.display import DisplayConfig
from voice_assist.config.enrolment import EnrolmentConfig
from voice_assist.config.pedal import PedalConfig

ROOT = Path(__file__).resolve().parents[3]
SOURCE = ROOT / "catkin_ws" / "src"
FOLDERS = {
    name: SOURCE / name / "config" for name in ("rst_control", "voice_assist", "session_log")
}
WHOLE = {  # files that one call loads, as their program does at its start
    FOLDERS["rst_control"] / "gen3_openrst.yaml": RobotFacts,
    FOLDERS["rst_control"] / "crtk.yaml": CrtkConfig,
    FOLDERS["rst_control"] / "kinova_bridge.yaml": BridgeConfig,
    FOLDERS["rst_control"] / "kinova_stand_in.yaml": StandInConfig,
    FOLDERS["rst_control"] / "kinova_limits.yaml": LimitsConfig,
    FOLDERS["rst_control"] / "torque_tension.yaml": TorqueTensionConfig,
    FOLDERS["voice_assist"] / "alarms.yaml": AlarmsConfig,
    FOLDERS["voice_assist"] / "believed.yaml": VoiceBelievedConfig,
    FOLDERS["voice_assist"] / "display.yaml": DisplayConfig,
    FOLDERS["voice_assist"] / "pedal.yaml": PedalConfig,
    FOLDERS["voice_assist"] / "devices.yaml": DevicesConfig,
    FOLDERS["voice_assist"] / "enrolment.yaml": EnrolmentConfig,
    FOLDERS["voice_assist"] / "commands_de.yaml": CommandsConfig,
    FOLDERS["voice_assist"] / "commands_es.yaml": CommandsConfig,
    FOLDERS["voice_assist"] / "commands_fr.yaml": CommandsConfig,
    FOLDERS["voice_assist"] / "commands_ja.yaml": CommandsConfig,
    FOLDERS["voice_assist"] / "endoscope_commands.yaml": CommandsConfig,
    FOLDERS["voice_assist"] / "theatre_commands.yaml": CommandsConfig,
    FOLDERS["session_log"] / "foxglove.yaml": FoxgloveConfig,
    FOLDERS["session_log"] / "recorder.yaml": RecorderConfig,
    FOLDERS["session_log"] / "report.yaml": ReportConfig,
    FOLDERS["session_log"] / "replay.yaml": ReplayConfig,
    ROOT / "paper" / "experiment.yaml": ExperimentConfig,
    ROOT / "demo" / "session.yaml": Script,
    ROOT / "demo" / "kinova_session.yaml": Script,
}
NODES = {  # nodes whose parameters have a section for each of several files
    "controller parameters": (MotionConfig, FOLDERS["rst_control"]),
    "simulator parameters": (SimulationConfig, FOLDERS["rst_control"]),
    "": (VoiceConfig, FOLDERS["voice_assist"]),
}
OVERLAYS = {  # files that change some keys of a node, loaded over its own; by the node's name
    FOLDERS["rst_control"] / "kinova_controller.yaml": "controller parameters",
}
Path_ = tuple[str | int, ...]


@dataclass(frozen=True, eq=False)
class Leaf:
    """One value in a settings file, or a list of values."""

    path: Path_
    rule: Rule
    is_list: bool = False
    size: int | None = None  # of a list that has one
    is_optional: bool = False
    has_free_name: bool = False  # its key is a name that the file chooses

    @property
    def key(self) -> str:
        return shown(self.path)

    @property
    def schema(self) -> str:
        """The key with [] for every place in a list."""
        return shown(tuple(step if isinstance(step, str) else "[]" for step in self.path))

    @property
    def is_entry(self) -> bool:
        """It is one number of a list, and no key."""
        return isinstance(self.path[-1], int)

    @property
    def is_first(self) -> bool:
        """Of lists of mappings it is in the first."""
        return all(step == 0 for step in self.path[:-1] if isinstance(step, int))


def shown(path: Path_) -> str:
    """A key as errors write it."""
    words = ""
    for step in path:
        if isinstance(step, int):
            words += f"[{step}]"
        elif step == "[]":
            words += step
        else:
            words += f".{step}" if words else step
    return words


@cache
def hints(kind: type) -> dict[str, object]:
    return typing.get_type_hints(kind)


def kinds() -> dict[Path, type]:
    """Dataclass of each settings file."""
    found = dict(WHOLE)
    for kind, folder in NODES.values():
        for field in dataclasses.fields(kind):
            found[folder / f"{field.name}.yaml"] = hints(kind)[field.name]
    return found


FILES = sorted(kinds())
files = pytest.mark.parametrize("path", FILES, ids=[path.name for path in FILES])


@cache
def _parsed(path: Path) -> dict:
    return yaml.load(path.read_text(encoding="utf-8"), Loader=yaml.CSafeLoader)


def content(path: Path) -> dict:
    return copy.deepcopy(_parsed(path))


def node_parameters(where: str) -> dict:
    """What a launch file puts on the parameter server for a node."""
    kind, folder = NODES[where]
    return {f.name: content(folder / f"{f.name}.yaml") for f in dataclasses.fields(kind)}


def leaves(kind: type, data: Mapping, path: Path_ = ()) -> Iterator[Leaf]:
    """Every value that stands in the file, with its rule."""
    for field in dataclasses.fields(kind):
        key = field.name.rstrip("_")
        if key in data:
            optional = field.default is not dataclasses.MISSING
            rule = field.metadata.get(RULE)
            yield from _value(hints(kind)[field.name], rule, data[key], (*path, key), optional)


def _value(hint, rule, value, path, optional=False) -> Iterator[Leaf]:
    if typing.get_origin(hint) is UnionType:
        (hint,) = (part for part in typing.get_args(hint) if part is not NoneType)
    inside = typing.get_args(hint)
    if dataclasses.is_dataclass(hint):
        yield from leaves(hint, value, path)
    elif typing.get_origin(hint) is Mapping:
        for name, entry in value.items():
            for leaf in _value(inside[1], rule, entry, (*path, name)):
                yield dataclasses.replace(leaf, has_free_name=True)
    elif typing.get_origin(hint) is tuple and dataclasses.is_dataclass(inside[0]):
        yield Leaf(path, rule, True)
        for index, entry in enumerate(value):
            yield from leaves(inside[0], entry, (*path, index))
    elif typing.get_origin(hint) is tuple:
        size = None if inside[-1] is Ellipsis else len(inside)
        yield Leaf(path, rule, True, size, optional)
        for index in range(len(value)):
            yield Leaf((*path, index), rule)
    else:
        yield Leaf(path, rule, is_optional=optional)


def at(data, path: Path_):
    for step in path:
        data = data[step]
    return data


GONE = object()  # in place of a value: the key is taken out


@contextlib.contextmanager
def changed(data, path: Path_, value):
    """The data with one value replaced, for a while."""
    holder, last = at(data, path[:-1]), path[-1]
    before = holder[last]
    if value is GONE:
        del holder[last]
    else:
        holder[last] = value
    try:
        yield data
    finally:
        holder[last] = before


@contextlib.contextmanager
def added(data, path: Path_, key: str, value):
    """The data with another key in the mapping at `path`, for a while."""
    holder = at(data, path)
    holder[key] = value
    try:
        yield data
    finally:
        del holder[key]


def mappings(kind: type, data: Mapping, path: Path_ = ()) -> Iterator[tuple[Path_, type]]:
    """Path and dataclass of every mapping in the file, the whole of it first."""
    yield path, kind
    for field in dataclasses.fields(kind):
        key, hint = field.name.rstrip("_"), hints(kind)[field.name]
        if key not in data:
            continue
        if typing.get_origin(hint) is UnionType:
            (hint,) = (part for part in typing.get_args(hint) if part is not NoneType)
        inside = typing.get_args(hint)
        if dataclasses.is_dataclass(hint):
            yield from mappings(hint, data[key], (*path, key))
        elif typing.get_origin(hint) is tuple and dataclasses.is_dataclass(inside[0]):
            for index, entry in enumerate(data[key]):
                yield from mappings(inside[0], entry, (*path, key, index))

# SPDX-License-Identifier: BSD-3-Clause
"""Where each argument of each launch file arrives: argument_places.yaml, and whether it does."""

from __future__ import annotations

import shlex
from dataclasses import dataclass
from pathlib import Path

import yaml
from rosgraph.names import ns_join

ROOT = Path(__file__).resolve().parents[2]
TABLE = ROOT / "tests" / "launch" / "argument_places.yaml"
OF_NODE = {
    "required": lambda node, value: node.required is value,
    "prefix": lambda node, value: node.prefix == value,
    "remap": lambda node, value: value in node.remaps.values(),
    "ROS_HOSTNAME": lambda node, value: node.environment["ROS_HOSTNAME"] == value,
    **{
        name: lambda node, value, name=name: node.machine[name] == str(value)
        for name in ("address", "user", "env_loader", "timeout")
    },
}


@dataclass(frozen=True)
class Argument:
    """A row of the table."""

    file: str
    name: str
    sample: str  # a value that is not the default
    places: list


def bases():
    """Arguments that are given beside, by launch file."""
    return {file: rows.get("base", []) for file, rows in _table().items()}


def rows():
    """All arguments of all launch files."""
    return [
        Argument(file, name, row[0], row[1:])
        for file, arguments in _table().items()
        for name, row in arguments.items()
        if name != "base"
    ]


def _table():
    return yaml.safe_load(TABLE.read_text(encoding="utf-8"))


def unmet(argument, value, reading, namespace="/", others=()):
    """Places that a value does not reach.

    Args:
        argument: Its row.
        value: As on the command line.
        reading: What roslaunch read.
        namespace: Of all nodes.
        others: Parameters of other arguments, which count more than those of a file.
    """
    return [
        place
        for place in argument.places
        if not _is_there(place, value, reading, namespace, set(others))
    ]


def parameters(argument):
    """Parameters that have the very value."""
    return {place for place in argument.places if isinstance(place, str) and place[0] == "/"}


def _is_there(place, value, reading, namespace, others):
    if isinstance(place, dict):
        ((name, values),) = place.items()
        meant = yaml.safe_load(value)
        return meant not in values or reading.parameters.get(name) == values[meant]
    kind, _, name = place.rpartition(" ")
    full = ns_join(namespace, name.lstrip("/"))
    found = reading.parameters.get(full)
    if not kind:
        return _is_same(found, value)
    if kind == "node":
        return (full in reading.nodes) is yaml.safe_load(value)
    if kind in OF_NODE:
        return OF_NODE[kind](reading.nodes[full], yaml.safe_load(value))
    if kind == "item":
        return yaml.safe_load(value) in (found or [])
    if kind.startswith("--"):
        words = shlex.split(found)
        return words[words.index(kind) + 1] == value
    if kind == "text":
        return found.strip() == Path(value).read_text("utf-8").strip()
    file = Path(value) if kind == "file" else Path(value) / kind
    return all(
        name in others or _is_same(reading.parameters.get(name), setting)
        for name, setting in _settings(file, full)
    )


def _is_same(found, given):
    return found == given or (isinstance(given, str) and yaml.safe_load(given) == found)


def _settings(file, namespace):
    """Full name and value of each setting of a file."""

    def leaves(name, value):
        if not isinstance(value, dict):
            return [(name, value)]
        return [leaf for key, part in value.items() for leaf in leaves(f"{name}/{key}", part)]

    return leaves(namespace, yaml.safe_load(file.read_text("utf-8")) or {})

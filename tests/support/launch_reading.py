# SPDX-License-Identifier: BSD-3-Clause
"""A command line of roslaunch, read as roslaunch reads it, with nothing started."""

from __future__ import annotations

import copy
import functools
import json
from dataclasses import asdict, dataclass
from unittest.mock import patch

import roslaunch
import yaml
from rosgraph.names import ns_join
from roslaunch import config, rlutil, xmlloader


@dataclass(frozen=True)
class Node:
    """What roslaunch would do to start one node."""

    required: bool
    respawn: bool
    prefix: str
    environment: dict[str, str]
    remaps: dict[str, str]
    machine: dict[str, str]


@dataclass(frozen=True)
class Reading:
    """What roslaunch would set and start.

    Attributes:
        parameters: By full name. One that a command gives has the words of the command.
        nodes: By full name.
    """

    parameters: dict[str, object]
    nodes: dict[str, Node]


_parsed = functools.cache(yaml.safe_load)  # nine tenths of a reading, and mostly of the same files


def loaded(words, runs_commands=False):
    """Roslaunch's own configuration of the words behind `roslaunch`.

    A parameter that a command gives has the words of the command, which is run only where asked
    for: checking the settings anew takes longer than all the rest. Raises RLException where
    roslaunch would end.
    """

    class Loader(xmlloader.XmlLoader):
        def param_value(self, *given):
            command = given[-1]
            if runs_commands or command is None:
                value = super().param_value(*given)
            return value if command is None else command

    _, files = roslaunch._get_optparse().parse_args(list(words))
    files = [(file, list(words)) for file in rlutil.resolve_launch_arguments(files)]
    with patch.object(yaml, "safe_load", lambda text: copy.deepcopy(_parsed(text))):
        return config.load_config_default(files, None, loader=Loader(), verbose=False)


def read(words, runs_commands=False):
    """What the words behind `roslaunch` would set and start; see `loaded`."""
    found = loaded(words, runs_commands)
    parameters = {name: parameter.value for name, parameter in found.params.items()}
    return Reading(
        parameters,
        {ns_join(node.namespace, node.name): _node(found, node) for node in found.nodes},
    )


def _node(found, node):
    machine = found.machines.get(node.machine_name)
    about = ("address", "user", "env_loader", "timeout")
    return Node(
        bool(node.required),
        bool(node.respawn),
        node.launch_prefix or "",
        dict(node.env_args),
        dict(node.remap_args),
        {name: str(getattr(machine, name)) for name in about} if machine else {},
    )


def dumped(reading):
    """As JSON, for another process."""
    return json.dumps(asdict(reading), default=str)


def restored(text):
    """What `dumped` wrote."""
    data = json.loads(text)
    return Reading(data["parameters"], {name: Node(**n) for name, n in data["nodes"].items()})

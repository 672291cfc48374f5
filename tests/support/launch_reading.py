# SPDX-License-Identifier: BSD-3-Clause
"""A command line of roslaunch, read as roslaunch reads it, with nothing started."""

from __future__ import annotations

import contextlib
import copy
import functools
import io
import json
import os
import subprocess
from dataclasses import asdict, dataclass
from pathlib import Path
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


@contextlib.contextmanager
def commands_here(words=()):
    """The launch files' own checks run in this process, as roslaunch of these words calls them.

    For each of them roslaunch starts Python anew, which takes longer than all the rest. Other
    programs are started as ever.
    """
    from rst_control.kinova import preflight  # not by the many who only read
    from typed_config import check

    mains = {"check_settings": check.main, "kinova_preflight": preflight.main}

    class Here(subprocess.Popen):
        def __new__(cls, command, *_, **__):
            is_ours = not isinstance(command, str) and Path(command[0]).name in mains
            return _done(mains, command) if is_ours else super().__new__(cls)

    with (
        patch.object(subprocess, "Popen", Here),
        patch.object(check, "caller_words", lambda: ["roslaunch", *words]),
    ):
        yield


def _done(mains, command):
    """What is left of a process of the command: its output and its status."""
    assert os.access(command[0], os.X_OK), command[0]
    printed, status = io.StringIO(), 0
    try:
        with contextlib.redirect_stdout(printed):
            mains[Path(command[0]).name](command[1:])
    except SystemExit as ended:
        status = ended.code
    return Done(status, (printed.getvalue().encode(), None))


@dataclass(frozen=True)
class Done:
    """Stands for a process that has ended."""

    returncode: int
    output: tuple[bytes, None]

    def communicate(self):
        return self.output


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

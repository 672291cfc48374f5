# SPDX-License-Identifier: BSD-3-Clause
"""Nodes that a launch would start a second time on one ROS master.

The master ends a node when another one registers under its name, in the middle of a motion, too.
"""

from __future__ import annotations

import argparse
import xml.etree.ElementTree as ElementTree
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import Any

import rosgraph

from typed_config.ros.xmlrpc import CALLER, FAILURES, ask, is_alive

SHARED = {"robot_state_publisher"}  # programs of which the newer takes the older's place unharmed


def running_again(file: Path, words: Sequence[str]) -> list[str]:
    """Nodes of a launch that run already, where this file starts one of them.

    Args:
        file: The launch file that asks.
        words: Command line of the program that reads it. Only roslaunch is checked: rostest starts
            a master of its own.
    """
    programs = [n for n, word in enumerate(words) if Path(word).name == "roslaunch"]
    if not programs:
        return []
    words = words[programs[0] + 1 :]
    master = _master_uri(words)
    registered = _registered(master)
    if not any(_is_of(file, name) for name in registered):
        return []  # so that reading the whole launch is rarely needed
    again = sorted(registered & set(_nodes(words)))
    return [name for name in again if is_alive(master, name)]


def _is_of(file: Path, name: str) -> bool:
    nodes = ElementTree.parse(file).getroot().iter("node")
    return name.rpartition("/")[2] in {node.attrib["name"] for node in nodes}


def _master_uri(words: Sequence[str]) -> str:
    parser = argparse.ArgumentParser(add_help=False, allow_abbrev=False)
    parser.add_argument("-p", "--port")
    port = parser.parse_known_args(list(words))[0].port
    return f"http://localhost:{port}/" if port else str(rosgraph.get_master_uri())


def _registered(master: str) -> set[str]:
    """Names of all nodes; none where no master runs."""
    try:
        state: Any = ask(master, "getSystemState", CALLER)
    except FAILURES:
        return set()
    return {name for part in state for _, names in part for name in names}


def _nodes(words: Sequence[str]) -> Collection[str]:
    """Full names of the nodes that a command line of roslaunch starts."""
    import roslaunch  # which takes longer than all the rest
    from roslaunch import config, rlutil, xmlloader

    class WithoutCommands(xmlloader.XmlLoader):  # type: ignore[misc]
        """Runs no command of a <param>: one of them runs this."""

        def param_value(self, *given: object) -> object:
            return "" if given[-1] is not None else super().param_value(*given)

    options, files = roslaunch._get_optparse().parse_args(list(words))
    about = ("node_args", "node_list", "find_node", "dump_params", "file_list", "ros_args")
    if any(getattr(options, name) for name in about):
        return ()  # it starts nothing
    try:
        files = [(file, list(words)) for file in rlutil.resolve_launch_arguments(files)]
        found = config.load_config_default(files, None, loader=WithoutCommands())
    except roslaunch.RLException:
        return ()  # roslaunch says why
    return {
        rosgraph.names.ns_join(node.namespace, node.name)
        for node in found.nodes
        if node.type not in SHARED
    }

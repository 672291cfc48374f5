# SPDX-License-Identifier: BSD-3-Clause
"""Processor time and memory of each node of a launch, from /proc."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

TICKS = os.sysconf("SC_CLK_TCK")
NAME = "__name:="
ROS = "ROS itself"  # master, rosout, roslaunch, robot_state_publisher
OF_ROS = ("rosout", "robot_state_publisher")


@dataclass(frozen=True)
class Usage:
    """What a node has used."""

    processor: float = 0.0  # [s] user and system
    memory: float = 0.0  # [MB] PSS: memory that processes share counts once among them

    def __add__(self, other: Usage) -> Usage:
        return Usage(self.processor + other.processor, self.memory + other.memory)


def usage(roots: Iterable[int]) -> dict[str, Usage]:
    """Usage by node, of all processes that descend from some.

    A process without a name of its own, such as a painter of pictures, is of the node that started
    it; what is of no node is of ROS itself.

    Args:
        roots: Numbers of the processes that were started.
    """
    parents = dict(_parents())
    found: dict[str, Usage] = {}
    for pid in parents:
        line = _line(pid, parents)
        if not set(line) & set(roots):
            continue
        name = next(filter(None, map(_node, line)), ROS)
        with suppress(OSError):  # it has ended meanwhile
            own = Usage(_processor(pid), _memory(pid))
            found[name] = found.get(name, Usage()) + own
    return found


def resident() -> int:
    """Memory of this process that lies in RAM now [bytes]."""
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE")


def between(first: Mapping[str, Usage], last: Mapping[str, Usage]) -> dict[str, float]:
    """Processor time of each node from one moment to another [s]; of those there at both."""
    return {name: last[name].processor - first[name].processor for name in first if name in last}


def _parents() -> Iterable[tuple[int, int]]:
    for place in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):
            yield int(place.name), int(_fields(int(place.name))[1])


def _line(pid: int, parents: Mapping[int, int]) -> list[int]:
    """A process and those that it descends from, itself first."""
    line = []
    while pid in parents:
        line.append(pid)
        pid = parents[pid]
    return line


def _node(pid: int) -> str:
    """Name that roslaunch gave to a process; empty without one."""
    try:
        words = Path(f"/proc/{pid}/cmdline").read_text(errors="replace").split("\0")
    except OSError:
        return ""
    name = next((word.removeprefix(NAME) for word in words if word.startswith(NAME)), "")
    return ROS if name in OF_ROS else name


def _fields(pid: int) -> list[str]:
    """Of its line of state, from the third on (proc(5))."""
    return Path(f"/proc/{pid}/stat").read_text(errors="replace").rpartition(")")[2].split()


def _processor(pid: int) -> float:
    fields = _fields(pid)
    return (int(fields[11]) + int(fields[12])) / TICKS


def _memory(pid: int) -> float:
    lines = Path(f"/proc/{pid}/smaps_rollup").read_text().splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith("Pss:")) * 1024 / 1e6

# SPDX-License-Identifier: BSD-3-Clause
"""What roslaunch takes without a word: arguments that do nothing, and a master open to others.

roslaunch keeps an argument that no launch file declares, and uses it nowhere. An argument of a part
that is not started does nothing, either. Without `ROS_IP` and `ROS_HOSTNAME` the master, roslaunch
itself and the nodes of others listen on all addresses.
"""

from __future__ import annotations

import difflib
import os
import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final

from typed_config.errors import ConfigError, Missing

NEEDS: Final = {  # arguments that do nothing without the part that another one starts
    **dict.fromkeys(("source", "device", "wav", "model", "model_device"), "voice"),
    **dict.fromkeys(("denoise", "profile", "candidates"), "voice"),
    **dict.fromkeys(("gui", "simulated_sensor", "simulation_overrides"), "simulate"),
    **dict.fromkeys(("speak", "alarm_sound"), "alarms"),
    **dict.fromkeys(("session", "sessions"), "record"),
    "display_port": "display",
}
_OFF = ("false", "0", "")
_ARGUMENT = re.compile(r"(?P<name>[A-Za-z]\w*):=")  # names with a leading "_" are ROS's own


def check_launch_line(
    file: Path, words: Sequence[str], environment: Mapping[str, str] | None = None
) -> None:
    """Check how a launch file was called.

    Args:
        file: The launch file that asks for this.
        words: Command line of the program that reads it.
        environment: Of that program; of this process where it is left out.

    Raises:
        ConfigError: An argument on the command line is unknown to this file, or belongs to a part
            that is not started, or no address is set.
    """
    given = os.environ if environment is None else environment
    if not (given.get("ROS_IP") or given.get("ROS_HOSTNAME")):
        raise ConfigError(
            "ROS_IP",
            Missing(),
            "an address of this machine; source the workspace's setup.sh, or export"
            " ROS_IP=127.0.0.1, else everybody on the network may command the robot",
        )
    if not any(_names(word, file) for word in words):
        return  # another launch file includes this one, and roslaunch checks what it passes on
    known = arguments(file)
    _require_parts(file, words)
    for match in filter(None, map(_ARGUMENT.match, words)):
        if match["name"] not in known:
            close = difflib.get_close_matches(match["name"], known, n=1)
            hint = f"did you mean {close[0]}:= ?" if close else "one of " + ", ".join(known)
            raise ConfigError(
                f"argument of {file.name}", match["name"], f"{hint} (roslaunch --ros-args explains)"
            )


def arguments(file: Path) -> dict[str, str]:
    """Arguments that a launch file declares for its caller, in its order, with their defaults."""
    declared = [one.attrib for one in ElementTree.parse(file).getroot().findall("arg")]
    return {one["name"]: one.get("default", "") for one in declared if "value" not in one}


def _require_parts(file: Path, words: Sequence[str]) -> None:
    given = {m["name"]: w[m.end() :] for w in words if (m := _ARGUMENT.match(w))}
    in_force = {**arguments(file), **given}
    for name, part in NEEDS.items():
        is_asked = given.get(name, "").lower() not in _OFF
        if is_asked and part in in_force and in_force[part].lower() in _OFF:
            raise ConfigError(name, given[name], f"only with {part}:=true, which it is a part of")


def caller_words() -> list[str]:
    """Command line of the process that started this one; empty where /proc does not show it."""
    try:
        line = Path("/proc", str(os.getppid()), "cmdline").read_bytes()
    except OSError:
        return []
    return line.decode(errors="replace").split("\0")[:-1]


def _names(word: str, file: Path) -> bool:
    """Whether a word of a command line is this file: by its path, or by its name in a package."""
    path = Path(word)
    return path.samefile(file) if path.exists() else word == file.name

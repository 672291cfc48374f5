# SPDX-License-Identifier: BSD-3-Clause
"""The settings of the launch, whatever the parameter server holds when a node is started anew.

The first start of a node keeps its settings beside them, under `~launched`. A later start of the
same launch takes those, and names each key that was changed since. A new launch clears both.
The controller compares the two of every node while it runs (`settings_watch.py`).
"""

from __future__ import annotations

import json
import os
from collections.abc import Collection, Mapping
from typing import Any, Final

import rospy

from typed_config.errors import ConfigError

KEPT: Final = "launched"
IN_FORCE: Final = "in_force"  # what was set since the launch, and counts after a restart too
RESTART: Final = "RESPAWN_RESTART"  # variable that `rst_control respawn` sets after a crash
MAX_NAMED: Final = 10  # keys that were changed, each in a line of the log
GONE: Final = "the settings of the launch, which are gone from the parameter server: launch anew"


def is_restart() -> bool:
    """Whether this process runs in place of one that crashed."""
    return RESTART in os.environ


def launch_settings(own: Collection[str] = (), is_first: bool = False) -> dict[str, Any]:
    """Private parameters of this node, as its launch set them.

    Args:
        own: Keys that the node itself sets: they are taken as they are.
        is_first: This is known to be the first start, whatever was kept before.

    Raises:
        ConfigError: After a crash nothing is kept any more.
    """
    now = dict(rospy.get_param("~", {}))
    kept = now.pop(KEPT, None)
    now.pop(IN_FORCE, None)
    if kept is None and is_restart():
        raise ConfigError(KEPT, kept, GONE)
    if kept is None or is_first:
        launched = {key: value for key, value in now.items() if key not in own}
        rospy.set_param(f"~{KEPT}", json.dumps(launched, sort_keys=True))
        return now
    then: dict[str, Any] = json.loads(kept)
    mine = {key: now.pop(key) for key in own if key in now}
    for words in differences(then, now)[:MAX_NAMED]:
        rospy.logerr("changed since the launch, and not taken: %s", words)
    return {**then, **mine}


def differences(then: Mapping[str, Any], now: Mapping[str, Any], where: str = "") -> list[str]:
    """Each key whose value is another, with both values."""
    found = []
    for key in sorted(then.keys() | now.keys()):
        name, old, new = f"{where}{key}", then.get(key), now.get(key)
        if isinstance(old, Mapping) and isinstance(new, Mapping):
            found += differences(old, new, f"{name}/")
        elif old != new:
            found.append(f"{name} is {new!r}, at the launch {old!r}")
    return found

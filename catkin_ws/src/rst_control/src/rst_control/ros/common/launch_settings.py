# SPDX-License-Identifier: BSD-3-Clause
"""The settings of the launch, whatever the parameter server holds when a node is started anew.

The first start of a node keeps its settings beside them, under `~launched`. A later start of the
same launch takes those, and names each key that was changed since. A new launch clears both.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any, Final

import rospy

KEPT: Final = "launched"
IN_FORCE: Final = "in_force"  # what was set since the launch, and counts after a restart too
MAX_NAMED: Final = 10  # keys that were changed, each in a line of the log


def launch_settings() -> dict[str, Any]:
    """Private parameters of this node, as its launch set them."""
    now = dict(rospy.get_param("~", {}))
    kept = now.pop(KEPT, None)
    now.pop(IN_FORCE, None)
    if kept is None:
        rospy.set_param(f"~{KEPT}", json.dumps(now, sort_keys=True))
        return now
    then: dict[str, Any] = json.loads(kept)
    for words in differences(then, now)[:MAX_NAMED]:
        rospy.logerr("changed since the launch, and not taken: %s", words)
    return then


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

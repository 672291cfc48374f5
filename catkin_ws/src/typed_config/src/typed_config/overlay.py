# SPDX-License-Identifier: BSD-3-Clause
"""Settings of one file over those of another."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


def overlaid(under: Mapping[str, Any], over: Mapping[str, Any]) -> dict[str, Any]:
    """What the parameters are when a file is loaded after another, as roslaunch does it.

    Mappings are merged, all else is replaced; neither argument is changed.
    """
    both = dict(under)
    for key, value in over.items():
        below = both.get(key)
        if isinstance(value, Mapping) and isinstance(below, Mapping):
            both[key] = overlaid(below, value)
        else:
            both[key] = value
    return both

# SPDX-License-Identifier: BSD-3-Clause
"""Where the topics of a system lie that was recorded from outside of its namespace."""

from __future__ import annotations

from collections.abc import Collection, Iterable


def namespaces_of(wanted: Iterable[str], recorded: Collection[str]) -> list[str]:
    """Namespaces, such as /left, that hold topics which are missing under their own names.

    Args:
        wanted: Topics, such as /rst_control/state.
        recorded: Topics of a recording.
    """
    missing = tuple(topic for topic in wanted if topic not in recorded)
    found = {name.removesuffix(topic) for name in recorded for topic in missing}
    return sorted(found - set(recorded))

# SPDX-License-Identifier: BSD-3-Clause
"""Whether the settings of all nodes are still those of their launch."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Final

Settings = Mapping[str, Any]
Differences = Callable[[Settings, Settings], list[str]]

MAX_NAMED: Final = 3  # of what differs, in one sentence
MAX_LENGTH: Final = 160  # characters of each
GONE_LOOKS: Final = 5  # for which settings are missing before they count: a new launch clears them


class LaunchedSettings:
    """Compares what the parameter server holds with what each node was launched with.

    A launch of one node clears its settings and sets them again. The node keeps them when it
    starts, a second or more later. Until then the present ones are compared with those known.

    Args:
        differences: Names each key that differs, as `launch_settings.differences` does.
    """

    def __init__(self, differences: Differences) -> None:
        self._differences = differences
        self._launched: dict[str, Settings] = {}  # by node, as first seen
        self._missing: dict[str, int] = {}  # by node, looks since something is missing
        self._named: set[str] = set()
        self.problem = ""  # what differs at this moment; empty: nothing

    def update(self, nodes: Mapping[str, tuple[Settings | None, Settings]]) -> str:
        """Take in what the server holds.

        Args:
            nodes: By name: what the node keeps of its launch, None where it keeps nothing, and its
                settings as they are now.

        Returns:
            What differs since the last time, in words; empty: nothing more than then.
        """
        found = [words for node in sorted(nodes) for words in self._of(node, *nodes[node])]
        for node in sorted(self._launched.keys() - nodes.keys()):
            found += self._of(node, None, {})
        self.problem, news = _shown(found), [words for words in found if words not in self._named]
        self._named = set(found)
        return _shown(news)

    def _of(self, node: str, kept: Settings | None, now: Settings) -> list[str]:
        launched = self._launched.get(node)
        if kept is None:
            return [] if launched is None else self._unkept(node, launched, now)
        self._missing.pop(node, None)
        if launched is None or kept == launched:
            self._launched[node] = kept
            given = {key: value for key, value in now.items() if key in kept}
            return [f"{node}: {words}" for words in self._differences(kept, given)]
        self._launched[node] = kept  # from now on it has these
        other = self._differences(launched, kept)
        return [f"{node} was launched anew, with other settings: {words}" for words in other]

    def _unkept(self, node: str, launched: Settings, now: Settings) -> list[str]:
        """What is wrong with a node that keeps nothing: it is being launched, or they are gone."""
        given = {key: value for key, value in now.items() if key in launched}
        changed = self._differences(_among(launched, given), given)
        every = self._differences(launched, given)
        if len(every) == len(changed):
            self._missing.pop(node, None)
        else:
            self._missing[node] = self._missing.get(node, 0) + 1
        if self._missing.get(node, 0) < GONE_LOOKS:
            return [f"{node}: {words}" for words in changed]
        return [f"{node}: {words}" for words in every] if given else [f"{node}: all are gone"]


def _among(then: Settings, now: Settings) -> Settings:
    """What of the earlier settings has a key, at any depth, that is there now."""
    return {
        key: _among(value, now[key])
        if isinstance(value, Mapping) and isinstance(now[key], Mapping)
        else value
        for key, value in then.items()
        if key in now
    }


def _shown(found: list[str]) -> str:
    more = len(found) - MAX_NAMED
    words = "; ".join(words[:MAX_LENGTH] for words in found[:MAX_NAMED])
    return f"{words}; and {more} more" if more > 0 else words

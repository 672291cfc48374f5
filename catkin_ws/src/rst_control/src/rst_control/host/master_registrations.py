# SPDX-License-Identifier: BSD-3-Clause
"""What a ROS master knows of nodes, so that another master can be given it."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Final

ANY_TYPE: Final = "*"
RUN: Final = "run_id"  # parameter, of each run of a master
Pairs = frozenset[tuple[str, str]]
Entries = list[list[object]]  # [[name, [node, ...]], ...] as the master lists them


@dataclass(frozen=True)
class Registrations:
    """Who publishes, subscribes and serves what."""

    publishers: Pairs = frozenset()  # topic and node
    subscribers: Pairs = frozenset()  # topic and node
    services: Pairs = frozenset()  # service and node
    types: Mapping[str, str] = field(default_factory=dict)  # of topics
    nodes: Mapping[str, str] = field(default_factory=dict)  # name and URI of its API
    service_uris: Mapping[str, str] = field(default_factory=dict)

    def of(self, names: Collection[str]) -> Registrations:
        """The part that concerns some nodes."""
        return Registrations(
            frozenset(pair for pair in self.publishers if pair[1] in names),
            frozenset(pair for pair in self.subscribers if pair[1] in names),
            frozenset(pair for pair in self.services if pair[1] in names),
            self.types,
            {name: uri for name, uri in self.nodes.items() if name in names},
            self.service_uris,
        )

    def without(self, other: Registrations) -> Registrations:
        """What the other one does not know."""
        return Registrations(
            self.publishers - other.publishers,
            self.subscribers - other.subscribers,
            self.services - other.services,
            self.types,
            self.nodes,
            self.service_uris,
        )

    def joined(self, other: Registrations) -> Registrations:
        """What either knows; where both do, this one's addresses count."""
        return Registrations(
            self.publishers | other.publishers,
            self.subscribers | other.subscribers,
            self.services | other.services,
            {**other.types, **self.types},
            {**other.nodes, **self.nodes},
            {**other.service_uris, **self.service_uris},
        )

    def news(self, before: Registrations) -> frozenset[str]:
        """Topics with a publisher that was not there before, or had another address."""
        return frozenset(
            topic
            for topic, name in self.publishers
            if (topic, name) not in before.publishers
            or self.nodes.get(name) != before.nodes.get(name)
        )

    def updates(self, topics: Collection[str]) -> dict[str, dict[str, list[str]]]:
        """Addresses of all publishers of some topics, for each node that subscribes to them."""
        found: dict[str, dict[str, list[str]]] = {}
        for topic, name in sorted(self.subscribers):
            if topic in topics and name in self.nodes:
                found.setdefault(name, {})[topic] = [
                    self.nodes[node]
                    for of, node in sorted(self.publishers)
                    if of == topic and node in self.nodes
                ]
        return found

    def calls(self, last: str = "") -> list[tuple[str, ...]]:
        """Methods of the master's API, each with its arguments, that register all of this.

        Publishers come first, so that a subscriber is notified of all of them at once. The node
        named `last` comes at the very end, so that its presence shows that all was done.
        """
        node, kind = self.nodes, self.types
        calls = [
            ("registerPublisher", name, topic, kind.get(topic, ANY_TYPE), node[name])
            for topic, name in sorted(self.publishers)
        ]
        calls += [
            ("registerSubscriber", name, topic, kind.get(topic, ANY_TYPE), node[name])
            for topic, name in sorted(self.subscribers)
        ]
        calls += [
            ("registerService", name, service, self.service_uris[service], node[name])
            for service, name in sorted(self.services)
            if self.service_uris.get(service)
        ]
        return sorted(calls, key=lambda call: call[1] == last)


def pairs_of(listed: Entries) -> Pairs:
    """Names with each of their nodes, of one list of the master's `getSystemState`."""
    return frozenset(
        (str(name), str(node))
        for name, nodes in listed
        if isinstance(nodes, list)
        for node in nodes
    )


def missing_parameters(
    known: Mapping[str, object], present: Mapping[str, object]
) -> dict[str, object]:
    """Parameters to set, by key, where a master has only `present` of what was known.

    What is there already stays as it is: the new master's own, and what was set meanwhile. The
    name of the run is never set: `roscore` gives its own, and gives up a master that has another.
    """
    return _missing({key: value for key, value in known.items() if key != RUN}, present)


def _missing(known: Mapping[str, object], present: Mapping[str, object]) -> dict[str, object]:
    found: dict[str, object] = {}
    for key, value in known.items():
        if key not in present:
            found[f"/{key}"] = value
        elif isinstance(value, Mapping) and isinstance(there := present[key], Mapping):
            deeper = _missing(value, there)
            found |= {f"/{key}{name}": inner for name, inner in deeper.items()}
    return found

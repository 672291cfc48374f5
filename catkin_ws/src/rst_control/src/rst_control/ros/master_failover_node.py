# SPDX-License-Identifier: BSD-3-Clause
"""Master failover: registers all nodes and parameters with a ROS master that was started again.

A ROS 1 node registers once. After a restart of the master its connections go on, but no new node
finds it, and all parameters are gone. This node registers every node that still runs, of any
language, and sets the parameters that are missing.

A master notifies subscribers of a new publisher once. A subscriber that misses the notice, or hangs
while it connects, never receives. This node repeats the notice twice; the others ignore it.
"""

from __future__ import annotations

import logging
import xmlrpc.client
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Final, cast

import rosgraph
import rospy

from rst_control.host.master_registrations import Registrations, missing_parameters, pairs_of
from typed_config.ros.starting import starting
from typed_config.ros.xmlrpc import FAILURES, ask, master, value_of

log = logging.getLogger("rosout.rst_control.master_failover")

PERIOD: Final = 0.5  # [s] between rounds; what was registered since the last one may be forgotten
PARAMETERS_EVERY: Final = 6  # rounds
RETRIES: Final = 120  # rounds for a node that hung when the others were registered
AGAIN: Final = (4, 12)  # rounds after which subscribers are notified of a new publisher again


class MasterFailover:
    """Copies the master's knowledge, and gives it back."""

    def __init__(self) -> None:
        self._own = rospy.get_name()
        self._known = Registrations()
        self._parameters: dict[str, object] = {}
        self._hanging: set[str] = set()
        self._to_notify: dict[int, set[str]] = {}  # topics, by the round in which they are due
        self._count = self._retries = 0

    def step(self) -> None:
        """Read the master once.

        Raises:
            OSError: It is not there, or does not answer.
            ValueError: It cannot be understood.
        """
        present = self._read_master()
        if self._known.nodes and self._own not in present.nodes:
            log.warning("another ROS master: all nodes are registered with it again")
            self._hanging, self._retries = set(self._known.nodes), RETRIES
        if self._hanging:
            self._restore(present)
            present = self._read_master()
        self._notify_again(present)
        self._known = present.joined(self._known.of(self._hanging))
        if self._count % PARAMETERS_EVERY == 0:
            self._parameters = cast(dict[str, object], self._ask("getParam", "/"))
        self._count += 1

    def _restore(self, present: Registrations) -> None:
        there = set(self._alive(self._hanging))
        lost = self._known.of(there).without(present)
        parameters = cast(dict[str, object], self._ask("getParam", "/"))
        calls: list[tuple[object, ...]] = [
            ("setParam", self._own, key, value)
            for key, value in missing_parameters(self._parameters, parameters).items()
        ]
        self._call([*calls, *lost.calls(last=self._own)])
        self._notify(lost)
        self._retries -= 1
        self._hanging -= there
        if self._retries <= 0:
            self._hanging.clear()

    def _alive(self, names: Iterable[str]) -> Iterable[str]:
        """Those of the nodes that answer; who hangs up is forgotten, who is silent is not."""
        for name in sorted(names):
            try:
                ask(self._known.nodes[name], "getPid", self._own)
            except TimeoutError:
                continue
            except FAILURES:
                self._hanging.discard(name)
                continue
            yield name

    def _notify_again(self, present: Registrations) -> None:
        """Notify subscribers of publishers that came a while ago."""
        self._remind(present.news(self._known))
        due = self._to_notify.pop(self._count, set())
        self._update(present.updates(due), present.nodes)

    def _remind(self, topics: Iterable[str]) -> None:
        """Plan to notify the subscribers of some topics again."""
        for rounds in AGAIN:
            self._to_notify.setdefault(self._count + rounds, set()).update(topics)

    def _notify(self, lost: Registrations) -> None:
        """Notify subscribers of all publishers: the master does so for new ones alone."""
        nodes = self._known.nodes
        present = replace(lost, publishers=self._read_master().publishers, nodes=nodes)
        topics = {topic for topic, _ in lost.subscribers}
        self._update(present.updates(topics), nodes)
        self._remind(topics)

    def _update(
        self, updates: Mapping[str, Mapping[str, list[str]]], nodes: Mapping[str, str]
    ) -> None:
        """Send some nodes the publishers of their topics; one that hangs is not waited for."""
        for name, topics in updates.items():
            for topic, uris in topics.items():
                try:
                    ask(nodes[name], "publisherUpdate", "/master", topic, uris)
                except TimeoutError:
                    break
                except FAILURES:
                    continue

    def _read_master(self) -> Registrations:
        state = cast(list[list[list[object]]], self._ask("getSystemState"))
        publishers, subscribers, services = (pairs_of(part) for part in state)
        types = dict(cast(list[tuple[str, str]], self._ask("getTopicTypes")))
        names = sorted({name for pairs in (publishers, subscribers, services) for _, name in pairs})
        served = sorted({service for service, _ in services})
        uris = self._call(
            [("lookupNode", self._own, name) for name in names]
            + [("lookupService", self._own, service) for service in served]
        )
        nodes = {name: uri for name, uri in zip(names, uris, strict=False) if uri}
        services_at = dict(zip(served, uris[len(names) :], strict=True))
        all_of_them = Registrations(publishers, subscribers, services, types, nodes, services_at)
        return all_of_them.of(nodes)

    def _call(self, calls: list[tuple[object, ...]]) -> list[str]:
        """Many calls in one; what fails gives an empty text."""
        if not calls:
            return []
        with master() as api:
            many = xmlrpc.client.MultiCall(api)
            for method, *arguments in calls:
                getattr(many, str(method))(*arguments)
            answers = many()
            return [_text(answers[k]) for k in range(len(calls))]

    def _ask(self, method: str, *arguments: object) -> object:
        return ask(rosgraph.get_master_uri(), method, self._own, *arguments)


def _text(answer: object) -> str:
    try:
        return str(value_of(answer))
    except ValueError:
        return ""


def main() -> None:
    """Run the node."""
    with starting("master_failover", __doc__, needs_clock=False):
        failover, is_there = MasterFailover(), True
    while not rospy.is_shutdown():
        try:
            failover.step()
            is_there = True
        except FAILURES as error:
            if is_there:
                log.error("the ROS master is lost: %s", error)
            is_there = False
        rospy.rostime.wallsleep(PERIOD)

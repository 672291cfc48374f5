# SPDX-License-Identifier: BSD-3-Clause
"""Finds the processes behind the ROS master and behind nodes, as far as they run on this host.

Nodes elsewhere, or in another container, are not found; what is known of them are their messages.
"""

from __future__ import annotations

import threading
from collections.abc import Iterable, Mapping
from contextlib import suppress
from typing import Final
from urllib.parse import urlsplit

import rosgraph
import rospy

from rst_control.host.processes import ENDED, Process, process_of
from rst_control.supervision.node_liveness import MASTER
from typed_config.ros.xmlrpc import FAILURES, ask

SEARCH_PERIOD: Final = 0.5  # [s] between searches for missing nodes, and checks of the master
SILENCES: Final = 2  # in a row after which the master counts as hanging
SILENT: Final = "does not answer"
UNREACHABLE: Final = "cannot be reached"


class Peers:
    """Who is watched, and which process each of them is.

    `step` is called again and again by a thread of its own, for answers may take long.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()  # of the next two
        self._wanted: frozenset[str] = frozenset()
        self._processes: dict[str, Process] = {}
        self._news = threading.Event()
        self._silences, self._master = 0, ""  # what is wrong with the master's answers

    def want(self, names: Iterable[str]) -> None:
        """Look for these nodes from now on, beside the master.

        Others are forgotten: a node that is wanted again may be a new process.
        """
        wanted = frozenset(names)
        if wanted == self._wanted:
            return
        with self._lock:
            self._wanted = wanted
            self._keep(self._processes)
        self._news.set()

    def state(self, name: str) -> str:
        """What has become of the master or a node; empty: it runs, or nothing is known."""
        process = self._processes.get(name)
        words = process.state() if process is not None else ""
        return words or (self._master if name == MASTER else "")

    def step(self) -> None:
        """Look for those who are not found yet, or have ended."""
        self._news.wait(SEARCH_PERIOD)
        self._news.clear()
        self._look_at_master()
        if not self._master:
            for name in self._wanted:
                if not self._is_running(name):
                    self._find(name)

    def _is_running(self, name: str) -> bool:
        process = self._processes.get(name)
        return process is not None and process.state() != ENDED

    def _look_at_master(self) -> None:
        uri = rosgraph.get_master_uri()
        try:
            pid = ask(uri, "getPid", rospy.get_name())
        except TimeoutError:
            self._silences += 1
            self._master = SILENT if self._silences >= SILENCES else self._master
            return
        except FAILURES:
            self._master = UNREACHABLE
            return
        self._silences, self._master = 0, ""
        if not self._is_running(MASTER):
            self._note(MASTER, pid, uri)

    def _find(self, name: str) -> None:
        with suppress(*FAILURES):  # it is not there, or is just going; its messages say so
            own = rospy.get_name()
            uri = str(ask(rosgraph.get_master_uri(), "lookupNode", own, name))
            self._note(name, ask(uri, "getPid", own), uri)

    def _note(self, name: str, pid: object, uri: str) -> None:
        """Keep the process that answers; where it is none of this host, nothing is known of it."""
        process = process_of(pid, urlsplit(uri).port or 0) if isinstance(pid, int) else None
        with self._lock:
            others = {n: found for n, found in self._processes.items() if n != name}
            self._keep(others if process is None else {**others, name: process})

    def _keep(self, processes: Mapping[str, Process]) -> None:
        """Know these from now on, without those that nobody asks for."""
        names = self._wanted | {MASTER}
        self._processes = {name: found for name, found in processes.items() if name in names}

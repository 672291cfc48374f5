# SPDX-License-Identifier: BSD-3-Clause
"""Watches those without whom a motion may not go on.

They are the master, who asked for it, who records it and who holds the dead-man.

A node of this host that is killed or stopped is noticed by the kernel's word, within a period; one
elsewhere that is killed by its connection, which closes; one elsewhere that hangs by its heartbeat
alone, where it has one.
"""

from __future__ import annotations

import time
from typing import Final

import rospy

from rst_control.execution.executor import Executor
from rst_control.ros.common.peers import Peers
from rst_control.ros.controller.dead_man_link import DeadManLink
from rst_control.ros.controller.recording_link import RecordingLink
from rst_control.supervision.node_liveness import MASTER, NodeLiveness
from typed_config.ros.connections import is_heard

PERIOD: Final = 0.01  # [s] between looks; one takes some 0.1 ms
HUNG_UP: Final = "hung up"


class LivenessWatch:
    """Reports who is lost. `step` and `peers.step` belong into threads of their own.

    Args:
        liveness: Takes the reports.
        executor: Says who asked for the present motion.
        spoken_by: Name of the voice node, which is always watched.
        links: Subscribers over which those who ask for motions are heard.
        recording: Knows the recorders, and is notified when one is lost.
        dead_man: Knows whether it is held.
    """

    def __init__(
        self,
        liveness: NodeLiveness,
        executor: Executor,
        spoken_by: str,
        links: tuple[rospy.Subscriber, ...],
        recording: RecordingLink,
        dead_man: DeadManLink,
    ) -> None:
        self._liveness, self._executor = liveness, executor
        self._spoken_by, self._links = spoken_by, links
        self._recording, self._dead_man = recording, dead_man
        self.peers = Peers()

    def step(self) -> None:
        """Look once."""
        time.sleep(PERIOD)
        owner = self._executor.owner
        names = {self._spoken_by, owner} - {""}
        recorders = self._recording.recorders
        self.peers.want(names | recorders)
        found = {name: self.peers.state(name) for name in (MASTER, *names)}
        if owner and not found[owner] and not any(is_heard(link, owner) for link in self._links):
            found[owner] = HUNG_UP
        self._liveness.report({name: words for name, words in found.items() if words})
        for name in recorders:
            if words := self.peers.state(name):
                self._recording.lost(name, words)
        view = self._executor.snapshot
        self._recording.check(view)
        self._dead_man.check(view)

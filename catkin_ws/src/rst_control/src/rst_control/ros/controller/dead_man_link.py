# SPDX-License-Identifier: BSD-3-Clause
"""Hears the dead-man, and brakes the motion under way when it is released or silent.

That there is one is kept in the node's private parameters, which a new launch clears. A controller
that is started anew within the launch asks for it before it is heard again.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from threading import Thread
from typing import Final

import rospy
from std_msgs.msg import Bool

from rst_control.admission.dead_man_gate import DeadMan
from rst_control.execution.executor import Executor
from rst_control.execution.snapshot import ControllerSnapshot
from rst_control.types import State
from typed_config.ros.known_publishers import KnownPublishers
from typed_config.ros.launch_settings import IN_FORCE
from typed_config.ros.xmlrpc import FAILURES

HAS_DEAD_MAN: Final = f"~{IN_FORCE}/has_dead_man"


class DeadManLink:
    """Feeds the dead-man, and acts on it.

    Args:
        dead_man: Is told what comes.
        executor: Brakes.
        known: Makes the subscriber.
        pedals: Nodes that are believed.
    """

    def __init__(
        self, dead_man: DeadMan, executor: Executor, known: KnownPublishers, pedals: Sequence[str]
    ) -> None:
        self._dead_man, self._executor = dead_man, executor
        self._is_kept = bool(rospy.get_param(HAS_DEAD_MAN, False))
        self._keeping: Thread | None = None
        if self._is_kept:
            dead_man.note(False)
        newest = {"tcp_nodelay": True, "queue_size": 1}
        self._subscriber = known.subscribe(
            "rst_control/dead_man", Bool, self._on_word, pedals, **newest
        )

    def check(self, view: ControllerSnapshot) -> None:
        """Stop what may not go on."""
        if view.mode.state is State.MOVING and (cause := self._dead_man.objection):
            self._executor.stop(cause)

    def _on_word(self, message: Bool) -> None:
        self._dead_man.note(message.data)
        if not self._is_kept and (self._keeping is None or not self._keeping.is_alive()):
            # In a thread: a master that hangs must not keep a release from being heard.
            self._keeping = Thread(target=self._keep, daemon=True)
            self._keeping.start()

    def _keep(self) -> None:
        with suppress(*FAILURES):  # the next word tries again
            rospy.set_param(HAS_DEAD_MAN, True)
            self._is_kept = True

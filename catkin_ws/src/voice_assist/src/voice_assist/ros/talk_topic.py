# SPDX-License-Identifier: BSD-3-Clause
"""The topic by which a pedal says whether voice counts; its silence closes the gate."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from threading import Lock, Thread

import rospy
from std_msgs.msg import Bool

from typed_config.ros.launch_settings import is_restart
from voice_assist.audio.talk_gate import TalkChange
from voice_assist.ros.believed import Believed
from voice_assist.ros.node_settings import HAS_GATE

SILENT_AFTER = 1.0  # [s] without a message, once there was one, after which voice does not count
KEPT = 20  # changes between two takes


class TalkTopic:
    """Changes of the gate that were received and not yet taken.

    After a crash of the voice node the gate is closed until it is heard, if there was one.
    """

    def __init__(self, clock: Callable[[], float], believed: Believed) -> None:
        """Subscribe; `clock` stamps each change [s]."""
        self._clock, self._lock = clock, Lock()
        self._changes: deque[TalkChange] = deque(maxlen=KEPT)
        self._is_open: bool | None = None  # None: no pedal was ever heard of
        self._heard = float("-inf")  # [s]
        self._is_kept = False  # the gate is known to a node that starts again
        if is_restart() and rospy.get_param(HAS_GATE, False):
            self._is_kept = True
            self._note(False)
        believed.hear("pedal", "voice_assist/talk", Bool, self._hear)

    def take(self) -> list[TalkChange]:
        """Changes since the last call, oldest first."""
        with self._lock:
            if self._is_open and self._clock() - self._heard > SILENT_AFTER:
                self._note(False)
            changes = list(self._changes)
            self._changes.clear()
        return changes

    def _hear(self, message: Bool) -> None:
        with self._lock:
            self._heard = self._clock()
            self._note(bool(message.data))
        if not self._is_kept:
            self._is_kept = True
            # In a thread: a master that hangs must not keep the gate from closing.
            Thread(target=rospy.set_param, args=(HAS_GATE, True), daemon=True).start()

    def _note(self, is_open: bool) -> None:
        if is_open is not self._is_open:
            self._is_open = is_open
            self._changes.append(TalkChange(is_open, self._clock()))

# SPDX-License-Identifier: BSD-3-Clause
"""What breaks in a soak, and for how long."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from bench.safety.soak.events import SoakEvent
from bench.safety.soak.robot import SensorLink, ServoRobot
from bench.safety.soak.voice import SoakVoice
from rst_control.types import JOINT_COUNT, Setpoint

Undo = Callable[[], None]


class Faults:
    """Those under way; each is undone when its time is over.

    Args:
        robot: The robot.
        link: Through which the controller sees it.
        voice: Whose heartbeat may end.
    """

    def __init__(self, robot: ServoRobot, link: SensorLink, voice: SoakVoice) -> None:
        self._robot, self._link, self._voice = robot, link, voice
        self.is_late = False  # the control loop does not come to its turn
        self.is_unrecorded = False  # the recorder's heartbeat is missing
        self.is_raising = False  # the next tick raises
        self._ends: list[tuple[float, Undo]] = []

    def begin(self, event: SoakEvent) -> None:
        """Let it break now."""
        robot, link = self._robot, self._link
        match event.words:
            case "joint states stop":
                self._set(link, "is_frozen", True, False, event)
            case "joints jump":
                self._set(link, "jump", event.size, None, event)
            case "tension is no number" | "tension jumps":
                self._set(link, "extra", event.size, None, event)
            case "recorder lost":
                self._set(self, "is_unrecorded", True, False, event)
            case "heartbeat lost":
                self._set(self._voice, "is_alive", False, True, event)
            case "voice node restarts":
                self._voice.restart()
            case "servo fault":
                robot.servo.fail("of the soak", robot.now)
            case "stray set-point":
                astray = robot.position + event.size
                robot.servo_jp(Setpoint(astray, np.zeros(JOINT_COUNT), robot.now))
            case "ticks come late":
                self._set(self, "is_late", True, False, event)
            case "error in the loop":
                self.is_raising = True
            case _:
                raise ValueError(f"no such fault: {event.words!r}")

    def tick(self, now: float) -> None:
        """Undo what has lasted long enough."""
        for end in [end for end in self._ends if end[0] <= now]:
            end[1]()
            self._ends.remove(end)

    def _set(
        self, what: object, name: str, value: object, normal: object, event: SoakEvent
    ) -> None:
        setattr(what, name, value)
        end = self._robot.now + event.duration
        self._ends.append((end, lambda: setattr(what, name, normal)))

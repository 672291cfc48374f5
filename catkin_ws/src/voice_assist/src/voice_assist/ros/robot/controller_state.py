# SPDX-License-Identifier: BSD-3-Clause
"""What the voice node knows of the robot: whether it moves, and its mode."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from rst_control.msg import ControllerState
from voice_assist.config.moving import MovingConfig
from voice_assist.pipeline.robot_mode import RobotMode
from voice_assist.pipeline.robot_motion import RobotMotion
from voice_assist.pipeline.unanswered_calls import UnansweredCalls
from voice_assist.ros.believed import Believed
from voice_assist.side_inputs import Observer, SideInput, SideInputKind
from voice_assist.types import Frame, Mode

TOPIC = "rst_control/state"


class ControllerFollower:
    """Both rules, fed with the controller's state and with each command that is passed on.

    Args:
        config: Settings of both rules.
        clock: A steady clock [s].
        observer: Gets each change of whether the robot moves, for a replay.
        believed: Makes the subscriber, which takes the state of the controller only.
    """

    def __init__(
        self,
        config: MovingConfig,
        clock: Callable[[], float],
        observer: Observer,
        believed: Believed,
    ) -> None:
        self._motion, self._mode, self._clock = RobotMotion(config), RobotMode(config), clock
        self._observer, self._was_moving = observer, False
        believed.hear("controller", TOPIC, ControllerState, self._take, queue_size=1)

    def _take(self, message: ControllerState) -> None:
        now = self._clock()
        self._motion.report(message.state, message.assistance_enabled, now)
        self._mode.report(message.assistance_enabled, now)

    def with_motion(self, frame: Frame) -> Frame:
        """The frame with whether the robot moves now, or may."""
        is_moving = self._motion.is_moving(self._clock())
        if is_moving != self._was_moving:
            self._was_moving = is_moving
            change = SideInput(SideInputKind.MOVING, frame.first_sample, is_moving=is_moving)
            self._observer(change)
        return replace(frame, is_moving=is_moving)

    def mode(self) -> Mode | None:
        """Its mode; None: it is unknown, or the voice may be about to change it."""
        return self._mode(self._clock())

    def arm(self, is_armed: bool) -> None:
        """Take whether motion commands count by voice."""
        self._motion.arm(is_armed)

    def send(self, is_motion: bool) -> None:
        """A command is about to be passed on."""
        for calls in self._calls(is_motion):
            calls.send()

    def answer(self, is_motion: bool) -> None:
        """The controller answered it, or failed to."""
        for calls in self._calls(is_motion):
            calls.answer(self._clock())

    def drop(self) -> None:
        """Commands that wait to be passed on never will be."""
        for calls in self._calls(is_motion=True):
            calls.drop(self._clock())

    def _calls(self, is_motion: bool) -> tuple[UnansweredCalls, ...]:
        """Where a command counts: every word for the mode, a motion for the motion as well."""
        return (self._motion.calls, self._mode.calls) if is_motion else (self._mode.calls,)

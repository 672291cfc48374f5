# SPDX-License-Identifier: BSD-3-Clause
"""OpenRST as its control node has it: what state it is in, whether it was homed, what it is sent.

The node switches position control on without having been homed, holds its last command for ever and
clamps nothing. So homing counts only where it was asked for and watched from here, and everything
sent is clamped here.
"""

from __future__ import annotations

from collections import deque
from dataclasses import replace
from enum import IntEnum
from typing import Final

import numpy as np

from rst_control.kinova.config import GripConfig, ToolConfig
from rst_control.kinova.feedback import JointFeedback
from rst_control.types import Vector, frozen_array

SPEED_SPAN: Final = 0.04  # [s] over which speeds are taken from positions, a few states of the node
UNHOMED = JointFeedback(np.zeros(3), np.zeros(3), np.zeros(3), -np.inf)


class ToolState(IntEnum):
    """What the node says of itself on `openrst_state`."""

    UNINITIALIZED = 0
    CONNECTED = 1
    READY = 2
    POSITION_CONTROL = 3
    TORQUE_CONTROL = 4


# Requests that lead to position control, each with the states that it may leave the node in.
HOMING = (
    ("connect", (ToolState.CONNECTED,)),
    ("calibrate", (ToolState.READY,)),
    ("pos_control_on", (ToolState.POSITION_CONTROL,)),
)
UNKNOWN = "OpenRST never reported its state: is its node running?"


class Tool:
    """Knows whether the tool may be moved, and what it may be sent.

    Args:
        config: Names, limits and tolerances.
        grip: How far the jaws may be commanded below where they stand.
    """

    def __init__(self, config: ToolConfig, grip: GripConfig) -> None:
        self._config, self._over_close = config, grip.over_close
        self._lower, self._upper = np.array(config.lower), np.array(config.upper)
        self._off_since = np.inf
        self.state: ToolState | None = None  # None: never reported
        self.is_homed = False
        self.feedback: JointFeedback | None = None
        self._places = deque[JointFeedback]()  # the newest of at least SPEED_SPAN

    def take(self, feedback: JointFeedback) -> None:
        """Take in its joints. Speeds follow from positions: the node reports 0, however it moves.

        Source: `OpenRSTControl::Read` writes positions alone.
        """
        places = self._places
        if not self.is_homed:  # homing sets the encoders anew
            places.clear()
        places.append(feedback)
        while len(places) > 2 and places[1].stamp <= feedback.stamp - SPEED_SPAN:
            places.popleft()
        span = feedback.stamp - places[0].stamp
        moved = feedback.position - places[0].position
        velocity = moved / span if span >= 0.5 * SPEED_SPAN else np.zeros(len(moved))
        self.feedback = replace(feedback, velocity=frozen_array(velocity, len(moved)))

    def update_state(self, number: int) -> None:
        """Take in what the node says.

        Homing is lost where it was disconnected or switched off, and it reports no joints then.
        """
        known = [state for state in ToolState if state.value == number]
        self.state = known[0] if known else None
        if self.state in (None, ToolState.UNINITIALIZED, ToolState.CONNECTED):
            self.is_homed, self.feedback = False, None

    @property
    def joints(self) -> JointFeedback:
        """Its joints as far as they are known: zeros until it was homed, as the node itself says.

        Nothing moves by them then: `objection` says why.
        """
        return self.feedback if self.is_homed and self.feedback is not None else UNHOMED

    def objection(self, now: float) -> str:
        """Why nothing may move, as far as the tool goes; empty: it may."""
        if self.state is None:
            return UNKNOWN
        if not self.is_homed:
            return (
                f"OpenRST is not homed (it says {self.state.name}): with the tool outside the "
                "patient, call robot/home_tool"
            )
        if self.state is not ToolState.POSITION_CONTROL:
            return f"OpenRST is in {self.state.name}, needed: POSITION_CONTROL"
        if self.feedback is None:
            return "OpenRST never reported its joints"
        age, allowed = now - self.feedback.stamp, self._config.feedback_age
        if age > allowed:
            return f"joints of OpenRST {age * 1e3:.0f} ms old, allowed {allowed * 1e3:.0f} ms"
        return ""

    def command(self, joints: Vector) -> Vector:
        """What the node is sent for a place of pitch and jaws [rad], in its own signs; shape (3,).

        The opening is held above the measured one less `over_close`, so that jaws kept open by
        tissue are not driven ever harder; then each joint is held within its limits.
        """
        pitch, left, right = joints.tolist()
        if (seen := self.feedback) is not None:
            least = float(seen.position[1:].sum()) - self._over_close
            missing = max(0.0, least - (left + right))
            left, right = left + 0.5 * missing, right + 0.5 * missing
        signed = np.array([pitch, left, right]) * np.array(self._config.signs)
        return np.clip(signed, self._lower, self._upper)

    def following(self, joints: Vector, now: float) -> str:
        """Whether pitch and yaw are where they were sent [rad]; the jaws may be kept open.

        Returns:
            What is wrong, after it was for `following_time`; empty: nothing.
        """
        if self.feedback is None:
            return ""
        seen, config = self.feedback.position, self._config
        pitch = float(seen[0] - joints[0])
        yaw = 0.5 * float((seen[1] - seen[2]) - (joints[1] - joints[2]))
        name, off = max((("pitch", pitch), ("yaw", yaw)), key=lambda pair: abs(pair[1]))
        if abs(off) <= config.following_error:
            self._off_since = np.inf
            return ""
        self._off_since = min(self._off_since, now)
        if now - self._off_since < config.following_time:
            return ""
        return (
            f"{name} of OpenRST {off:+.3f} rad off its course for {config.following_time:.1f} s, "
            f"allowed {config.following_error:.3f}"
        )


class Grip:
    """Whether tissue lies between the jaws: they were sent to close, and stay open.

    Args:
        config: Openings and times.
    """

    def __init__(self, config: GripConfig) -> None:
        self._config = config
        self._since: float | None = None  # [s] when the jaws began to say something else
        self.is_gripped = False

    def update(self, commanded: float, measured: float, now: float) -> bool:
        """Take in both openings [rad] at a time [s]; whether tissue is held."""
        config = self._config
        shows = commanded <= config.closed and measured - commanded >= config.contact
        if shows is self.is_gripped:
            self._since = None
            return self.is_gripped
        self._since = now if self._since is None else self._since
        if now - self._since >= (config.contact_time if shows else config.lost_time):
            self.is_gripped, self._since = shows, None
        return self.is_gripped

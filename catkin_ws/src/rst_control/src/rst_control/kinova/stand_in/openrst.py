# SPDX-License-Identifier: BSD-3-Clause
"""OpenRST's control node and its three joints.

It grants every request that it knows: position control without homing too, and then takes the
joints to stand at zero wherever they are. Its last command holds for ever, through homing too.
Nothing is clamped, and a joint sent past its range is driven against its stop. Joint states come
only once it is ready.

Source of the command: JointGroupPositionController of ros_controllers, which starts once.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence

import numpy as np

from rst_control.kinova.stand_in.config import OpenRstConfig
from rst_control.kinova.stand_in.homing import Homing
from rst_control.kinova.tool import ToolState
from rst_control.types import Vector

log = logging.getLogger("rosout.rst_control.openrst")

Reply = Callable[[bool], None]
STILL = 1e-6  # [rad/s] below which a joint stands


class OpenRst:
    """The tool's node; positions in its own signs.

    Args:
        config: Speeds, stops and homing.
        position: Pitch, left and right jaw at the start [rad]. Shape (3,).
    """

    def __init__(self, config: OpenRstConfig, position: Sequence[float] | Vector) -> None:
        self._config, self._stops = config, np.array(config.stops)
        self.position, self.velocity = np.array(position, dtype=float), np.zeros(3)
        self.state, self.is_homed = ToolState.UNINITIALIZED, False
        self._command: Vector | None = None  # None: the controller never ran
        self._homing: Homing | None = None
        self._reply: Reply | None = None
        self._last = -np.inf

    @property
    def is_moving(self) -> bool:
        """A joint moves; one that is driven against a stop or tissue does not."""
        return self._homing is not None or bool(self.velocity.any())

    @property
    def reported(self) -> Vector | None:
        """Joint positions as its encoders report them [rad], shape (3,); None: it reports none."""
        if self.state < ToolState.READY:
            return None
        return self.position.copy() if self.is_homed else np.zeros(3)

    def request(self, message: str, reply: Reply) -> bool:
        """Ask for something; the answer comes at once, but for homing, which takes its time.

        Returns:
            Whether the request is known; one that is not makes the service call fail.
        """
        known = {
            "connect": self._connect,
            "disconnect": self._disconnect,
            "calibrate": self._calibrate,
            "pos_control_on": lambda: self._control(ToolState.POSITION_CONTROL),
            "torque_control_on": lambda: self._control(ToolState.TORQUE_CONTROL),
            "control_off": self._control_off,
        }
        if message not in known:
            log.error("request %r, allowed: %s", message, ", ".join(known))
            return False
        self._reply = reply
        known[message]()
        if self._homing is None:
            reply(True)
        return True

    def take_command(self, values: Sequence[float]) -> None:
        """`effort_controller/command`: pitch, left and right jaw [rad]; held until the next."""
        if len(values) != 3:
            log.error("command of %d numbers, allowed: 3; not executed", len(values))
            return
        if not np.isfinite(values).all():
            log.error("command with a number that is not finite: what a motor does then is unknown")
            return
        if self._command is not None:
            self._command = np.array(values, dtype=float)

    def step(self, now: float, is_gripping: bool) -> None:
        """Move on to a time [s].

        Args:
            now: Never goes back.
            is_gripping: Tissue between the jaws keeps them from closing further.
        """
        time = 0.0 if np.isinf(self._last) else now - self._last
        self._last = now
        if time <= 0.0:
            return
        before = self.position.copy()
        if self._homing is not None:
            self.position = self._homing.step(self.position, time)
            if self._homing.is_done:
                self._end_homing()
        else:
            self._drive(time)
        if is_gripping:
            self._keep_open()
        self.velocity = (self.position - before) / time
        self.velocity[np.abs(self.velocity) < STILL] = 0.0

    def _gap(self) -> Vector:
        """What the controller has left to do, as it sees it, and as far as the stops let it."""
        is_driven = self.state is ToolState.POSITION_CONTROL and self._command is not None
        if not is_driven or self._command is None or self._homing is not None:
            return np.zeros(3)
        seen = self.position if self.is_homed else np.zeros(3)  # unhomed encoders read zero
        gap = self._command - seen
        room = np.clip(self.position + gap, -self._stops, self._stops) - self.position
        if not self.is_homed:  # it goes on pushing the way of the command
            room = np.where(gap == 0.0, 0.0, np.sign(gap) * self._stops - self.position)
        return np.where(np.abs(room) < 1e-7, 0.0, room)

    def _drive(self, time: float) -> None:
        gap, config = self._gap(), self._config
        most = config.acceleration * time
        braking = np.sqrt(most**2 + 2.0 * config.acceleration * np.abs(gap)) - most
        wanted = np.sign(gap) * np.minimum(np.minimum(braking, config.speed), np.abs(gap) / time)
        slower = np.abs(wanted) < np.abs(self.velocity)
        speed = np.where(
            slower, wanted, self.velocity + np.clip(wanted - self.velocity, -most, most)
        )
        self.position = np.clip(self.position + speed * time, -self._stops, self._stops)

    def _keep_open(self) -> None:
        pitch, left, right = self._signed(self.position)
        missing = 0.5 * max(0.0, self._config.tissue_opening - (left + right))
        self.position = self._signed(np.array([pitch, left + missing, right + missing]))

    def _signed(self, joints: Vector) -> Vector:
        """From the node's signs to our model's, or back."""
        return np.array(self._config.signs) * joints

    def _connect(self) -> None:
        self.state = ToolState.CONNECTED

    def _disconnect(self) -> None:
        self.state = ToolState.UNINITIALIZED

    def _control(self, state: ToolState) -> None:
        if self.state is not ToolState.READY:
            log.error("OpenRST is not READY but %s; granted all the same", self.state.name)
        self._enter(state)

    def _control_off(self) -> None:
        self.state = ToolState.CONNECTED

    def _calibrate(self) -> None:
        if self.state is ToolState.CONNECTED:
            self._homing = Homing(self._config)
            return
        self._enter(ToolState.READY)  # without having homed

    def _enter(self, state: ToolState) -> None:
        """Be in a state in which the controller runs; its first command is where it starts."""
        self.state = state
        if self._command is None:
            self._command = self.reported

    def _end_homing(self) -> None:
        self._homing, self.is_homed = None, True
        self._enter(ToolState.READY)
        if self._reply is not None:
            self._reply(True)

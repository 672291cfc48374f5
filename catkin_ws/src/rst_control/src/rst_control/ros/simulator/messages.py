# SPDX-License-Identifier: BSD-3-Clause
"""Messages that the simulator sends 500 times a second, as bytes; its clock in stamps of ROS."""

from __future__ import annotations

import struct

import numpy as np
from numpy.typing import NDArray

from rst_control.ros.common.raw_messages import WrittenJointState, WrittenWrench
from rst_control.ros.common.serialization import name_block
from rst_control.ros.common.wall_clock import followed, wall_offset
from rst_control.simulation.physics import JointReading
from rst_control.types import BASE, JOINTS

_HEADER = struct.Struct("<3I")  # sequence number, seconds, nanoseconds
_COUNT = struct.Struct("<I")


class Stamper:
    """Translates the simulator's time into stamps of ROS and back.

    In real time the simulator counts time.monotonic(), and stamps follow the wall clock; else
    stamps are its own time.
    """

    def __init__(self, is_real_time: bool) -> None:
        self._is_real_time = is_real_time
        self._offset = wall_offset() if is_real_time else 0.0

    def follow_wall_clock(self) -> None:
        """Take over a jump of the wall clock, if there was one."""
        if self._is_real_time:
            self._offset = followed(self._offset)

    def split(self, now: float) -> tuple[int, int]:
        """Seconds and nanoseconds of the simulator's time."""
        seconds, rest = divmod(now + self._offset, 1.0)
        return int(seconds), int(rest * 1e9)

    def simulated(self, stamp: float) -> float:
        """Simulator's time of a stamp [s]."""
        return stamp - self._offset


class StateWriter:
    """Writes joint states and tension; all that never changes is written once."""

    def __init__(self, stamper: Stamper) -> None:
        self._stamper, self._sent = stamper, 0
        count = _COUNT.pack(len(JOINTS))
        self._joints_head = _text(BASE) + name_block(JOINTS) + count
        self._count, self._wrench_head = count, _text(BASE)
        self._no_torque = bytes(24)

    def joints(self, now: float, reading: JointReading) -> WrittenJointState:
        """Joint states of a moment [s]."""
        self._sent += 1
        return WrittenJointState(
            b"".join(
                (
                    _HEADER.pack(self._sent & 0xFFFFFFFF, *self._stamper.split(now)),
                    self._joints_head,
                    reading.position.tobytes(),
                    self._count,
                    reading.velocity.tobytes(),
                    self._count,
                    reading.effort.tobytes(),
                )
            )
        )

    def rest(self, now: float, position: NDArray[np.float64]) -> WrittenJointState:
        """Where the joints are held [rad], shape (10,), from a moment [s] on."""
        still = np.zeros(len(JOINTS))
        return self.joints(now, JointReading(position, still, still))

    def wrench(self, now: float, force: NDArray[np.float64]) -> WrittenWrench:
        """Force of the tissue on the jaws [N] at a moment [s]."""
        head = _HEADER.pack(self._sent & 0xFFFFFFFF, *self._stamper.split(now))
        return WrittenWrench(head + self._wrench_head + force.tobytes() + self._no_torque)


def _text(words: str) -> bytes:
    return _COUNT.pack(len(words)) + words.encode()

# SPDX-License-Identifier: BSD-3-Clause
"""Messages that the simulator sends 500 times a second, as bytes; its clock in stamps of ROS."""

from __future__ import annotations

import struct
from itertools import count

import numpy as np
from numpy.typing import NDArray

from rst_control.ros.common.raw_messages import WrittenJointState, WrittenWrench
from rst_control.ros.common.serialization import name_block
from rst_control.ros.common.wall_clock import RosClock
from rst_control.simulation.physics import JointReading
from rst_control.types import BASE, JOINTS

_HEADER = struct.Struct("<3I")  # sequence number, seconds, nanoseconds
_COUNT = struct.Struct("<I")


class Stamper:
    """Translates the simulator's time into stamps of ROS.

    In real time the simulator counts time.monotonic(), and stamps follow the wall clock; else
    stamps are its own time. `ahead` tells how far stamps are ahead of its time now [s].
    """

    def __init__(self, is_real_time: bool) -> None:
        self.ahead = RosClock().ahead if is_real_time else lambda: 0.0

    def split(self, now: float) -> tuple[int, int]:
        """Seconds and nanoseconds of the simulator's time."""
        seconds, rest = divmod(now + self.ahead(), 1.0)
        return int(seconds), int(rest * 1e9)


class StateWriter:
    """Writes joint states and tension; all that never changes is written once.

    The messages of a topic are numbered without gaps, as a recorder counts those that it misses.
    """

    def __init__(self, stamper: Stamper) -> None:
        self._stamper = stamper
        self._joints, self._rests, self._wrenches = count(1), count(1), count(1)
        self._length = _COUNT.pack(len(JOINTS))
        self._joints_head = _text(BASE) + name_block(JOINTS) + self._length
        self._wrench_head = _text(BASE)
        self._no_torque = bytes(24)

    def joints(self, now: float, reading: JointReading) -> WrittenJointState:
        """Joint states of a moment [s]."""
        return self._state(next(self._joints), now, reading)

    def rest(self, now: float, position: NDArray[np.float64]) -> WrittenJointState:
        """Where the joints are held [rad], shape (10,), from a moment [s] on."""
        still = np.zeros(len(JOINTS))
        return self._state(next(self._rests), now, JointReading(position, still, still))

    def wrench(self, now: float, force: NDArray[np.float64]) -> WrittenWrench:
        """Force of the tissue on the jaws [N] at a moment [s]."""
        head = self._header(next(self._wrenches), now)
        return WrittenWrench(head + self._wrench_head + force.tobytes() + self._no_torque)

    def _state(self, number: int, now: float, reading: JointReading) -> WrittenJointState:
        return WrittenJointState(
            b"".join(
                (
                    self._header(number, now),
                    self._joints_head,
                    reading.position.tobytes(),
                    self._length,
                    reading.velocity.tobytes(),
                    self._length,
                    reading.effort.tobytes(),
                )
            )
        )

    def _header(self, number: int, now: float) -> bytes:
        return _HEADER.pack(number & 0xFFFFFFFF, *self._stamper.split(now))


def _text(words: str) -> bytes:
    return _COUNT.pack(len(words)) + words.encode()

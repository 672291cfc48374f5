# SPDX-License-Identifier: BSD-3-Clause
"""What arm and tool last said of their joints, in our order, names and turns."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from rst_control.errors import RstError
from rst_control.kinematics.joint_limits import TURN
from rst_control.types import Vector, frozen_array


class BadFeedback(RstError):
    """Joint states that cannot be used."""


@dataclass(frozen=True, eq=False)
class JointFeedback:
    """Joints at one moment; each array of shape (n,), read-only."""

    position: Vector  # [rad]
    velocity: Vector  # [rad/s]
    effort: Vector  # [N m]; zeros where none is reported
    stamp: float  # [s] steady clock, when it arrived


def unwrapped(position: Vector, last: Vector) -> Vector:
    """Positions [rad] by whole turns as near to the last ones as can be; both of shape (n,).

    The arm's driver reports angles between -pi and pi, also of joints that turn for ever. Where
    the last one is NaN the position is left as it is.
    """
    return position - TURN * np.nan_to_num(np.round((position - last) / TURN))


def rows_of(message: object) -> dict[str, Sequence[float]]:
    """Values of a sensor_msgs/JointState, as `FeedbackReader.read` takes them."""
    return {row: getattr(message, row) for row in ("position", "velocity", "effort")}


class FeedbackReader:
    """Puts joint states of a driver into our order.

    Args:
        names: Joints as the driver names them, in our order.
        signs: Our joint over the driver's, each 1 or -1; shape (n,).
        near: Angles [rad] that the first state is half a turn from, at most. NaN: a joint that
            does not turn for ever; it is always as reported. None: the driver's angles do not start
            again after a turn. Shape (n,).
    """

    def __init__(
        self, names: Sequence[str], signs: Sequence[float], near: Sequence[float] | None
    ) -> None:
        self._names, self._signs = tuple(names), np.array(signs)
        self._last = None if near is None else np.array(near, dtype=float)

    def read(
        self,
        names: Sequence[str],
        values: Mapping[str, Sequence[float]],
        arrived: float,
    ) -> JointFeedback:
        """Take in one message.

        Args:
            names: Of its joints, in its order; others than ours are passed over.
            values: Its `position` [rad], `velocity` [rad/s] and `effort` [N m]; that may be empty.
            arrived: Steady clock [s].

        Raises:
            BadFeedback: A joint is missing, a value too, or it is no number.
        """
        places = {name: place for place, name in enumerate(names)}
        missing = [name for name in self._names if name not in places]
        if missing:
            raise BadFeedback(f"joint states without {missing[0]}, but with {', '.join(names)}")
        order = [places[name] for name in self._names]
        position = self._signs * _picked("position", values["position"], order, len(names))
        velocity = self._signs * _picked("velocity", values["velocity"], order, len(names))
        effort = np.zeros(len(order))
        if len(values["effort"]):
            effort = self._signs * _picked("effort", values["effort"], order, len(names))
        if self._last is not None:
            position = unwrapped(position, self._last)
            self._last = np.where(np.isnan(self._last), np.nan, position)
        count = len(order)
        return JointFeedback(
            frozen_array(position, count),
            frozen_array(velocity, count),
            frozen_array(effort, count),
            arrived,
        )


def _picked(what: str, given: Sequence[float], order: list[int], count: int) -> Vector:
    if len(given) != count:
        raise BadFeedback(f"joint states with {len(given)} values of {what}, allowed: {count}")
    picked = np.array(given, dtype=float)[order]
    if not np.isfinite(picked).all():
        raise BadFeedback(f"joint states whose {what} is {picked.tolist()}, allowed: finite")
    return picked

# SPDX-License-Identifier: BSD-3-Clause
"""What the arm makes of a velocity: each joint changes to it as fast as its driver lets it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rst_control.types import Vector

TINY = 1e-12
LEAST_SPACING = 0.75  # periods between two velocities; each is made for a whole one


def next_due(due: float, now: float, period: float) -> float:
    """When the velocity after the one that was due, and is sent now, is due [s].

    The beat of the periods is kept where the velocity was a little late. Two velocities in short
    order would each change the joints' speeds as for a whole period.
    """
    return max(due + period, now + LEAST_SPACING * period)


@dataclass(frozen=True, eq=False)
class Ramp:
    """Motion of all joints from one velocity sent to the next; each array of shape (n,)."""

    begun: float  # [s]
    position: Vector  # [rad] when it began
    velocity: Vector  # [rad/s] when it began
    wanted: Vector  # [rad/s] as sent
    acceleration: Vector  # [rad/s^2] of the change

    def at(self, time: float) -> tuple[Vector, Vector]:
        """Position [rad] and velocity [rad/s] at a time [s], from `begun` on."""
        passed = max(0.0, time - self.begun)
        change = self.wanted - self.velocity
        needed = np.abs(change) / self.acceleration
        ramp = np.minimum(passed, needed)
        velocity = self.velocity + np.sign(change) * self.acceleration * ramp
        way = 0.5 * (self.velocity + velocity) * ramp + velocity * (passed - ramp)
        return self.position + way, np.where(passed >= needed, self.wanted, velocity)


def velocity_for(way: Vector, velocity: Vector, acceleration: Vector, time: float) -> Vector:
    """Velocities to send so that the joints go a way within a time, their change included.

    Of w = |u - v|, the change of velocity, the way is v t + w t - w^2 / (2 a) while it is reached
    within the time t. A way too long for that gets the change that the whole time allows.

    Args:
        way: To be gone [rad]. Shape (n,).
        velocity: At the start, v [rad/s]. Shape (n,).
        acceleration: Of each joint, a [rad/s^2]. Shape (n,).
        time: [s].

    Returns:
        Velocities u [rad/s]. Shape (n,).
    """
    more = way - velocity * time
    full = acceleration * time
    root = np.sqrt(np.maximum(0.0, full * full - 2.0 * acceleration * np.abs(more)))
    wanted: Vector = velocity + np.sign(more) * (full - root)
    return wanted


def feasible_share(way: Vector, velocity: Vector, acceleration: Vector, time: float) -> float:
    """Share of a way that all joints can go within a time, as near to all of it as can be.

    Where the way is too much for one joint, all go the same share of it, so that they stay on the
    straight line between where they are and where they should be.

    Args:
        way: To be gone [rad]. Shape (n,).
        velocity: At the start [rad/s]. Shape (n,).
        acceleration: Of each joint [rad/s^2]. Shape (n,).
        time: [s].
    """
    half = 0.5 * acceleration * time * time
    moves = np.abs(way) > TINY
    if not moves.any():
        return 1.0
    coast, way, half = velocity[moves] * time, way[moves], half[moves]
    ends = np.sort(np.array([(coast - half) / way, (coast + half) / way]), axis=0)
    low, high = float(ends[0].max()), float(ends[1].min())
    if low > high:  # some must go further than others can
        return min(1.0, max(0.0, 0.5 * (low + high)))
    return max(0.0, min(max(1.0, low), high))


def catching_up(behind: Vector, acceleration: Vector, time: float) -> float:
    """Share of what the joints are behind to be made up for within a time.

    So much that the speed it takes can still be taken off on the rest: more would swing about the
    course, each joint by its own. Of a share x that is (x b / t)^2 = 2 a (1 - x) b.

    Args:
        behind: Of the course, b [rad]. Shape (n,).
        acceleration: That the course leaves each joint, a [rad/s^2]. Shape (n,).
        time: t [s].
    """
    least = float((2.0 * acceleration * time * time / np.maximum(np.abs(behind), TINY)).min())
    return 2.0 / (1.0 + float(np.sqrt(1.0 + 4.0 / least)))  # is (sqrt(q^2 + 4 q) - q) / 2

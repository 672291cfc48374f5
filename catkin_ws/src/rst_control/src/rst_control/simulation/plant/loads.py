# SPDX-License-Identifier: BSD-3-Clause
"""Torques that loads of tool and shaft ask of the joints: J^T F, from the frames of the robot."""

from __future__ import annotations

from typing import Any

from rst_control.kernels import kernel


@kernel
def add_load(frames: Any, count: int, point: Any, force: Any, torques: Any) -> None:
    """Add to `torques` (count,) what a force (3,) [N] at a point (3,) [m] turns the joints by.

    Of a joint about z at o that is z . ((point - o) x force) [N m].

    Args:
        frames: Poses of all frames in base_link (12, 3, 4).
        count: Of the joints from the base on that the force turns.
        point: Base frame, [m].
        force: Base frame, [N].
        torques: Added to [N m].
    """
    for i in range(count):
        dx = point[0] - frames[i, 0, 3]
        dy = point[1] - frames[i, 1, 3]
        dz = point[2] - frames[i, 2, 3]
        torques[i] += frames[i, 0, 2] * (dy * force[2] - dz * force[1])
        torques[i] += frames[i, 1, 2] * (dz * force[0] - dx * force[2])
        torques[i] += frames[i, 2, 2] * (dx * force[1] - dy * force[0])

# SPDX-License-Identifier: BSD-3-Clause
"""Joints that keep the shaft in a trocar which has moved, with the tip where it was."""

from __future__ import annotations

from typing import Final

import numpy as np

from rst_control.kinematics import forward
from rst_control.kinematics.rcm import rcm_jacobian, rcm_offset
from rst_control.kinematics.robot_model import RobotModel
from rst_control.types import ARM_COUNT, PLAN_COUNT, Vector

ITERATIONS: Final = 4  # of Newton's method: from 8 mm the rest is far below a nanometre
IN_TROCAR: Final = 1e-3  # [m] from the tip to the trocar: nearer, J loses rank
RANK: Final = 1e-6  # of the largest singular value: below it the tip is in the trocar
PASSES: Final = 10  # of the fixed point: each leaves about a tenth
SHALLOW, DEEP = 0.03, 0.08  # [m] of the tip in the trocar: from here the tip begins to be kept


def tip_share(depth: float) -> float:
    """Share of the tip's place that is kept, from 0 to 1, at a depth in the trocar [m].

    Near the trocar the tip cannot stay while the trocar moves: the tool goes along as a whole.
    """
    u = min(max((depth - SHALLOW) / (DEEP - SHALLOW), 0.0), 1.0)
    return u * u * (3.0 - 2.0 * u)


def shifted_joints(model: RobotModel, q: Vector, trocar: Vector, shift: Vector) -> Vector:
    """Change of the arm's joints that follows a shift of the trocar.

    Solved for e(dq) = 0 by Newton's method with the least change of the joints:
    e is the trocar's lateral offset in the shaft's frame, less that before the shift, and the tip's
    place, less that before; J dq = -e with dq = -J^+ e. With the tip in the trocar both say the
    same, so J has less than full rank: the pseudo-inverse drops singular values below `RANK`.
    Elsewhere J^+ = J^T (J J^T)^-1, which costs less.

    Args:
        model: The robot.
        q: Planning configuration towards the trocar where it was [rad]. Shape (9,).
        trocar: Where it was, base frame, [m]. Shape (3,).
        shift: By which it moved, base frame, [m]. Shape (3,).

    Returns:
        Change of the planning configuration [rad]; zero for the tool's. Shape (9,).
    """
    if not shift.any():
        return np.zeros(PLAN_COUNT)
    q, moved = np.array(q), trocar + shift
    frames = np.empty((12, 3, 4))
    J_tip, J_rcm = np.empty((6, PLAN_COUNT)), np.zeros((2, PLAN_COUNT))
    forward.forward(model.chain, q, frames)
    lateral = np.array(rcm_offset(frames, trocar)[:2])
    tip = frames[forward.TIP, :, 3].copy()
    depth = float((tip - trocar) @ frames[forward.SHAFT, :, 2])
    tip += (1.0 - tip_share(depth)) * shift
    change = np.zeros(PLAN_COUNT)
    for _ in range(ITERATIONS):
        forward.forward(model.chain, q + change, frames)
        rcm_jacobian(frames, moved, J_rcm)
        forward.tip_jacobian(frames, 1.0, J_tip)
        off = np.array(rcm_offset(frames, moved)[:2]) - lateral
        error = np.concatenate([off, frames[forward.TIP, :, 3] - tip])
        J = np.vstack([J_rcm[:, :ARM_COUNT], J_tip[:3, :ARM_COUNT]])
        if abs(depth) > IN_TROCAR:
            change[:ARM_COUNT] -= J.T @ np.linalg.solve(J @ J.T, error)
        else:
            change[:ARM_COUNT] -= np.linalg.lstsq(J, error, rcond=RANK)[0]
    return change


def held_shift(model: RobotModel, q: Vector, trocar: Vector, shift: Vector) -> Vector:
    """Change by `shifted_joints` that joints hold already: the fixed point d = s(q - d).

    Args:
        model: The robot.
        q: Planning configuration towards the trocar where it is now [rad]. Shape (9,).
        trocar: Where it was, base frame, [m]. Shape (3,).
        shift: By which it moved, base frame, [m]. Shape (3,).

    Returns:
        The change [rad], so that q less it is the configuration towards the trocar where it was;
        zero for the tool's. Shape (9,).
    """
    change = np.zeros(PLAN_COUNT)
    for _ in range(PASSES):
        change = shifted_joints(model, np.array(q) - change, trocar, shift)
    return change

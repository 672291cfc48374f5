# SPDX-License-Identifier: BSD-3-Clause
"""Jacobians of the kernels, as arrays, and finite differences to judge them by."""

import numpy as np

from rst_control.kinematics.rcm import rcm_jacobian

STEP = 1e-6  # [rad] of finite differences


def rcm_jacobian_at(configuration, trocar):
    """Derivative of the lateral offset by q [m/rad]. Shape (2, 9)."""
    J = np.full((2, 9), np.nan)
    rcm_jacobian(configuration.frames, trocar, J)
    return J


def differences(function, q, step=STEP):
    """Derivative of a function of q (n,) by central differences. Shape (..., n)."""
    columns = []
    for joint in range(len(q)):
        change = np.zeros(len(q))
        change[joint] = step
        columns.append((function(q + change) - function(q - change)) / (2.0 * step))
    return np.stack(columns, axis=-1)

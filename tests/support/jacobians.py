# SPDX-License-Identifier: BSD-3-Clause
"""Jacobians of the kernels, as arrays."""

from __future__ import annotations

import numpy as np

from rst_control.kinematics.rcm import rcm_jacobian


def rcm_jacobian_at(configuration, trocar):
    """Derivative of the lateral offset by q [m/rad]. Shape (2, 9)."""
    J = np.full((2, 9), np.nan)
    rcm_jacobian(configuration.frames, trocar, J)
    return J

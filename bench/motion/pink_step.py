# SPDX-License-Identifier: BSD-3-Clause
"""One differential-IK step of `pin-pink` with a task for the trocar, to compare ours with.

Only `make bench` installs `pin-pink` (requirements-bench.txt).
"""

from __future__ import annotations

import numpy as np
import pink
import pinocchio as pin
from numpy.typing import NDArray
from pink.configuration import Configuration
from pink.tasks import FrameTask, Task

from rst_control.config import URDF_FILE

Array = NDArray[np.float64]
SOLVER = "daqp"  # the fastest dense one that qpsolvers has for this size


class RcmTask(Task):  # type: ignore[misc]
    """Keeps the shaft's line through the trocar: two lateral errors in the frame of the shaft.

    Args:
        trocar: Base frame, [m]. Shape (3,).
        cost: Of one metre off.
    """

    def __init__(self, trocar: Array, cost: float) -> None:
        super().__init__(cost=cost, gain=1.0, lm_damping=0.0)
        self._trocar = trocar

    def __repr__(self) -> str:
        return f"RcmTask(cost={self.cost})"

    def compute_error(self, configuration: Configuration) -> Array:
        """Lateral place of the trocar in the shaft's frame [m]. Shape (2,)."""
        shaft = configuration.get_transform_frame_to_world("interface_link")
        return np.array(shaft.actInv(self._trocar)[:2])

    def compute_jacobian(self, configuration: Configuration) -> Array:
        """Derivative of the error by the joints [m/rad]. Shape (2, nv)."""
        shaft = configuration.get_transform_frame_to_world("interface_link")
        inside = shaft.actInv(self._trocar)
        J = configuration.get_frame_jacobian("interface_link")
        # In its own frame the shaft moves by v + w x p where the trocar is; the trocar stands.
        return -(J[:3] - pin.skew(inside) @ J[3:])[:2]


class PinkStep:
    """Solves one step towards a pose of the tool tip with the shaft through the trocar.

    Args:
        joints: At the start, in the order of the URDF [rad]. Shape (10,).
        trocar: Base frame, [m]. Shape (3,).
        period: Of the control loop [s].
    """

    def __init__(self, joints: Array, trocar: Array, period: float) -> None:
        self._model = pin.buildModelFromUrdf(str(URDF_FILE))
        self._data, self._period = self._model.createData(), period
        self._tip = FrameTask("tool_tip", position_cost=1.0, orientation_cost=0.1)
        self._rcm = RcmTask(trocar, cost=10.0)
        self.q = self.configuration_vector(joints)

    def configuration_vector(self, joints: Array) -> Array:
        """Pinocchio's configuration: joints that turn for ever count as cosine and sine."""
        q = pin.neutral(self._model)
        for joint, angle in zip(list(self._model.joints)[1:], joints, strict=True):
            if joint.nq == 2:
                q[joint.idx_q : joint.idx_q + 2] = np.cos(angle), np.sin(angle)
            else:
                q[joint.idx_q] = angle
        return np.array(q)

    def step(self, T_base_tip: Array) -> Array:
        """Move `q` by one period towards a pose (4, 4) of tool_tip in base_link."""
        configuration = Configuration(self._model, self._data, self.q)
        self._tip.set_target(pin.SE3(T_base_tip[:3, :3], T_base_tip[:3, 3]))
        tasks = (self._tip, self._rcm)
        velocity = pink.solve_ik(
            configuration, tasks, self._period, SOLVER, damping=1e-8, safety_break=False
        )
        self.q = configuration.integrate(velocity, self._period)
        return self.q

    def rcm_error(self) -> float:
        """How far the shaft is off the trocar at `q` [m]."""
        here = Configuration(self._model, self._data, self.q)
        return float(np.linalg.norm(self._rcm.compute_error(here)))

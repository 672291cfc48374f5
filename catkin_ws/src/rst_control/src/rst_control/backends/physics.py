# SPDX-License-Identifier: BSD-3-Clause
"""The robot as PyBullet moves it: ten position-servoed joints under gravity, pushed at the jaws.

Each joint is a motor that closes its gap to the course within one step, as far as its torque
allows. PyBullet solves all motors together with the dynamics, so a load at the tip costs accuracy
only where a torque limit is reached. Computed torque with integral action was tried, too: as exact
in free motion, but a sudden 2 N at the tip moved joint_5 by 0.14 mrad before it was made up for,
against 0.001 mrad with motors.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from types import TracebackType

import numpy as np
import pybullet
from numpy.typing import NDArray

from rst_control.types import JOINTS

GRAVITY = 9.81  # [m/s^2]
SOLVER_ITERATIONS = 50  # 20 leave up to 7 urad, 100 less than 0.3 urad (measured)
MOTOR_GAIN = 1.0  # share of the gap to the course that is closed in one step
FINGERS = ("finger_left_link", "finger_right_link")

STRAIGHT = (0.0, 0.0, 0.0, 1.0)  # quaternion of no rotation

Vector = NDArray[np.float64]
Point = tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class JointReading:
    """Joints after a step; each of shape (10,)."""

    position: Vector  # [rad]
    velocity: Vector  # [rad/s]
    effort: Vector  # [N m], of the motors


class RobotPhysics:
    """One PyBullet world with the robot in it; a context manager.

    Args:
        urdf: Model of the robot.
        position: Joints at the start [rad]. Shape (10,).
        step: Time of one step [s].
    """

    def __init__(self, urdf: Path, position: Vector, step: float) -> None:
        self.time_step = step
        self._client = pybullet.connect(pybullet.DIRECT)
        self._on = {"physicsClientId": self._client}
        self._robot = load_robot(urdf, self._client)
        links = link_indices(self._robot, self._client)
        self._joints = joint_indices(self._robot, self._client)
        self._fingers = [links[name] for name in FINGERS]
        info = [pybullet.getJointInfo(self._robot, j, **self._on) for j in self._joints]
        self.torque_limits = np.array([entry[10] for entry in info], dtype=float)
        self._forces = self.torque_limits.tolist()
        self._gains = [MOTOR_GAIN] * len(self._joints), [1.0] * len(self._joints)
        self._set_up(position)
        self._tip_in_finger = self._tip_offset(links["tool_tip"])
        self._tips = self._jaw_tips()

    def drive(self, position: Vector, velocity: Vector) -> None:
        """Set the course of the next step.

        Args:
            position: Where each joint should be now [rad]. Shape (10,).
            velocity: Mean speed during the step [rad/s]. Shape (10,).
        """
        pybullet.setJointMotorControlArray(
            self._robot,
            self._joints,
            pybullet.POSITION_CONTROL,
            targetPositions=position.tolist(),
            targetVelocities=velocity.tolist(),
            forces=self._forces,
            positionGains=self._gains[0],
            velocityGains=self._gains[1],
            **self._on,
        )

    def push_jaws(self, force: Vector) -> None:
        """Push at the tips of both jaws, half each, during the next step.

        Args:
            force: Sum of both, base frame, [N]. Shape (3,).
        """
        half = (0.5 * force).tolist()
        for finger, tip in zip(self._fingers, self._tips, strict=True):
            pybullet.applyExternalForce(
                self._robot, finger, half, tip, pybullet.WORLD_FRAME, **self._on
            )

    def step(self) -> JointReading:
        """Move on by one step and read the joints."""
        pybullet.stepSimulation(**self._on)
        self._tips = self._jaw_tips()
        return self.read()

    def read(self) -> JointReading:
        """Joints as they are now."""
        states = pybullet.getJointStates(self._robot, self._joints, **self._on)
        return JointReading(
            position=np.array([s[0] for s in states]),
            velocity=np.array([s[1] for s in states]),
            effort=np.array([s[3] for s in states]),
        )

    @property
    def grasp_centre(self) -> Vector:
        """Point between the tips of the jaws, base frame, [m]. Shape (3,)."""
        centre: Vector = 0.5 * np.add(self._tips[0], self._tips[1])
        return centre

    def shaft(self) -> tuple[Vector, Vector]:
        """Both ends of the shaft (interface_link, pitch_link), base frame, [m]. Shapes (3,)."""
        links = link_indices(self._robot, self._client)
        first, second = (self._frame(links[n])[0] for n in ("interface_link", "pitch_link"))
        return np.array(first), np.array(second)

    def close(self) -> None:
        """Leave the world; calling it twice does no harm."""
        if self._client >= 0:
            pybullet.disconnect(self._client)
            self._client = -1

    def __enter__(self) -> RobotPhysics:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def _set_up(self, position: Vector) -> None:
        pybullet.setGravity(0.0, 0.0, -GRAVITY, **self._on)
        pybullet.setPhysicsEngineParameter(
            fixedTimeStep=self.time_step,
            numSolverIterations=SOLVER_ITERATIONS,
            solverResidualThreshold=0.0,
            deterministicOverlappingPairs=1,
            **self._on,
        )
        for link in range(-1, pybullet.getNumJoints(self._robot, **self._on)):
            pybullet.changeDynamics(
                self._robot,
                link,
                linearDamping=0.0,
                angularDamping=0.0,
                jointDamping=0.0,
                **self._on,
            )
        for joint, angle in zip(self._joints, position, strict=True):
            pybullet.resetJointState(self._robot, joint, float(angle), 0.0, **self._on)

    def _tip_offset(self, tool_tip: int) -> Point:
        inverse = pybullet.invertTransform(*self._frame(self._fingers[0]))
        place = pybullet.multiplyTransforms(*inverse, *self._frame(tool_tip))[0]
        return place[0], place[1], place[2]

    def _jaw_tips(self) -> tuple[Point, ...]:
        return tuple(
            pybullet.multiplyTransforms(*self._frame(finger), self._tip_in_finger, STRAIGHT)[0]
            for finger in self._fingers
        )

    def _frame(self, link: int) -> tuple[Point, tuple[float, float, float, float]]:
        state = pybullet.getLinkState(self._robot, link, computeForwardKinematics=1, **self._on)
        return state[4], state[5]


def load_robot(urdf: Path, client: int) -> int:
    """Load the robot, fixed at its base, with the inertias of its URDF.

    Returns:
        PyBullet's number of the body.

    Raises:
        FileNotFoundError: There is no such file.
    """
    if not urdf.is_file():
        raise FileNotFoundError(f"no robot model at {urdf}")
    flags = pybullet.URDF_USE_INERTIA_FROM_FILE
    return int(pybullet.loadURDF(str(urdf), useFixedBase=True, flags=flags, physicsClientId=client))


def joint_indices(robot: int, client: int) -> list[int]:
    """PyBullet's numbers of the ten joints, in the order of JOINTS."""
    count = pybullet.getNumJoints(robot, physicsClientId=client)
    info = [pybullet.getJointInfo(robot, j, physicsClientId=client) for j in range(count)]
    by_name = {entry[1].decode(): entry[0] for entry in info}
    return [by_name[name] for name in JOINTS]


def link_indices(robot: int, client: int) -> dict[str, int]:
    """PyBullet's number of each link by its name."""
    count = pybullet.getNumJoints(robot, physicsClientId=client)
    info = [pybullet.getJointInfo(robot, j, physicsClientId=client) for j in range(count)]
    return {entry[12].decode(): entry[0] for entry in info}

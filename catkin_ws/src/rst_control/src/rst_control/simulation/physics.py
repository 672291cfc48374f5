# SPDX-License-Identifier: BSD-3-Clause
"""The robot as PyBullet moves it: ten position-servoed joints under gravity, pushed at the jaws.

Each joint is a motor that closes its gap to the course within one step, as far as its torque
allows. PyBullet solves all motors together with the dynamics, exactly (Dantzig's method), so a load
at the tip costs accuracy only where a torque limit is reached. Friction, play and bending of a real
arm are left out. PyBullet's default solver takes twice the time and leaves 0.2 urad.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import NamedTemporaryFile
from typing import Self

import numpy as np
import pybullet

from rst_control.kinematics import forward
from rst_control.kinematics.mounting import gravity_in_base
from rst_control.kinematics.robot_model import RobotModel
from rst_control.kinematics.robot_model import load_robot as load_model
from rst_control.kinematics.rotations import quaternion
from rst_control.simulation.jaw_tips import JawTips
from rst_control.simulation.rigid_parts import joined
from rst_control.types import JOINTS, Vector

MOTOR_GAIN = 1.0  # share of the gap to the course that is closed in one step
WRIST, PITCH = "joint_7", "joint_pitch"  # their links carry the shaft, and begin at its end
JOINT_NAME, TORQUE_LIMIT, LINK_NAME = 1, 10, 12  # fields of getJointInfo
FINGERS = JOINTS[8:]


@dataclass(frozen=True, eq=False, slots=True)
class JointReading:
    """Joints after a step; each of shape (10,)."""

    position: Vector  # [rad]
    velocity: Vector  # [rad/s]
    effort: Vector  # [N m], of the motors


class BulletWorld:
    """One connection to PyBullet; a context manager.

    Args:
        mode: pybullet.DIRECT, or pybullet.GUI for a window.
    """

    def __init__(self, mode: int = pybullet.DIRECT) -> None:
        self._client = pybullet.connect(mode)

    def close(self) -> None:
        """Leave the world; calling it twice does no harm."""
        if self._client >= 0:
            pybullet.disconnect(self._client)
            self._client = -1

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


class RobotPhysics(BulletWorld):
    """One PyBullet world with the robot in it; a context manager.

    Args:
        urdf: Model of the robot.
        position: Joints at the start [rad]. Shape (10,).
        step: Time of one step [s].
        gravity: `scene.gravity`; empty: as the URDF has it.

    Raises:
        FileNotFoundError: There is no such model.
        RobotModelError: The URDF says another way of gravity.
    """

    def __init__(
        self, urdf: Path, position: Vector, step: float, gravity: Sequence[float] = ()
    ) -> None:
        self.time_step, self._model = step, load_model(urdf)
        self.gravity = gravity_in_base(self._model, gravity)  # [m/s^2]
        super().__init__()
        self._on = {"physicsClientId": self._client}
        self._robot = _load_parts(urdf, self._client, self._model)
        self._links = link_indices(self._robot, self._client)
        self._joints = joint_indices(self._robot, self._client)
        self._fingers = [self._links[self._model.link_of[name]] for name in FINGERS]
        self._wrist = self._model.link_of[WRIST]
        self._turning = [n for n in range(len(JOINTS)) if n not in self._model.locked]
        motors = [self._joints[n] for n in self._turning]
        info = [pybullet.getJointInfo(self._robot, j, **self._on) for j in motors]
        self._motors = {
            "jointIndices": motors,
            "controlMode": pybullet.POSITION_CONTROL,
            "forces": [float(entry[TORQUE_LIMIT]) for entry in info],  # [N m], never exceeded
            "positionGains": [MOTOR_GAIN] * len(motors),
            "velocityGains": [1.0] * len(motors),
            **self._on,
        }
        self._set_up(position)
        self._tips_at = JawTips(self._model)
        self._tips = self._tips_at(np.array(position))

    def drive(self, position: Vector, velocity: Vector) -> None:
        """Set the course of the next step.

        Args:
            position: Where each joint should be now [rad]. Shape (10,).
            velocity: Mean speed during the step [rad/s]. Shape (10,).
        """
        pybullet.setJointMotorControlArray(
            self._robot,
            targetPositions=position[self._turning].tolist(),
            targetVelocities=velocity[self._turning].tolist(),
            **self._motors,
        )

    def push_jaws(self, force: Vector) -> None:
        """Push at the tips of both jaws, half each, during the next step.

        Args:
            force: Sum of both, base frame, [N]. Shape (3,).
        """
        half = (0.5 * force).tolist()
        if not any(half):
            return
        for finger, tip in zip(self._fingers, self._tips[:2].tolist(), strict=True):
            pybullet.applyExternalForce(
                self._robot, finger, half, tip, pybullet.WORLD_FRAME, **self._on
            )

    def step(self) -> JointReading:
        """Move on by one step and read the joints."""
        pybullet.stepSimulation(**self._on)
        reading = self.read()
        self._tips = self._tips_at(reading.position)
        return reading

    def read(self) -> JointReading:
        """Joints as they are now."""
        states = pybullet.getJointStates(self._robot, self._joints, **self._on)
        position, velocity, _, effort = zip(*states, strict=True)
        return JointReading(np.array(position), np.array(velocity), np.array(effort))

    @property
    def grasp_centre(self) -> Vector:
        """Point between the tips of the jaws, base frame, [m]. Shape (3,)."""
        return self._tips[2]

    def shaft(self) -> tuple[Vector, Vector]:
        """Both ends of the shaft (interface_link, pitch joint), base frame, [m]. Shapes (3,)."""
        place, turn = self._pose(self._wrist)
        interface = place + turn @ self._model.chain[forward.SHAFT, :, 3]
        return interface, self._pose(self._model.link_of[PITCH])[0]

    def _set_up(self, position: Vector) -> None:
        pybullet.setGravity(*self.gravity.tolist(), **self._on)
        pybullet.setPhysicsEngineParameter(
            fixedTimeStep=self.time_step,
            constraintSolverType=pybullet.CONSTRAINT_SOLVER_LCP_DANTZIG,
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

    def _pose(self, link: str) -> tuple[Vector, Vector]:
        """Where a link is [m] and how it is turned, base frame. Shapes (3,) and (3, 3)."""
        state = pybullet.getLinkState(
            self._robot, self._links[link], computeForwardKinematics=1, **self._on
        )
        return np.array(state[4]), np.reshape(pybullet.getMatrixFromQuaternion(state[5]), (3, 3))


def _load_parts(urdf: Path, client: int, model: RobotModel) -> int:
    """Load the robot's moving parts only, for the physics; PyBullet reads nothing but files."""
    with NamedTemporaryFile("w", suffix=".urdf", encoding="utf-8") as file:
        file.write(joined(urdf.read_text(encoding="utf-8")))
        file.flush()
        return load_robot(Path(file.name), client, model)


def load_robot(urdf: Path, client: int, model: RobotModel | None = None) -> int:
    """Load the robot, fixed at its base, with the inertias of its URDF; the world is base_link.

    Args:
        urdf: File that PyBullet reads.
        client: Of PyBullet.
        model: How its base hangs on its root; None: read from the file.

    Returns:
        PyBullet's number of the body.

    Raises:
        FileNotFoundError: There is no such file.
    """
    if not urdf.is_file():
        raise FileNotFoundError(f"no robot model at {urdf}")
    flags = pybullet.URDF_USE_INERTIA_FROM_FILE
    options = {"useFixedBase": True, "flags": flags, "physicsClientId": client}
    model = load_model(urdf) if model is None else model
    root = np.linalg.inv(model.T_root_base)
    options["basePosition"] = root[:3, 3].tolist()
    options["baseOrientation"] = quaternion(root[:3, :3])
    return int(pybullet.loadURDF(str(urdf), **options))


def joint_indices(robot: int, client: int) -> list[int]:
    """PyBullet's numbers of the ten joints, in the order of JOINTS."""
    by_name = _numbers(robot, client, JOINT_NAME)
    return [by_name[name] for name in JOINTS]


def link_indices(robot: int, client: int) -> dict[str, int]:
    """PyBullet's number of each link by its name."""
    return _numbers(robot, client, LINK_NAME)


def _numbers(robot: int, client: int, field: int) -> dict[str, int]:
    count = pybullet.getNumJoints(robot, physicsClientId=client)
    info = [pybullet.getJointInfo(robot, j, physicsClientId=client) for j in range(count)]
    return {entry[field].decode(): entry[0] for entry in info}

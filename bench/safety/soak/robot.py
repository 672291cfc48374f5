# SPDX-License-Identifier: BSD-3-Clause
"""The robot of the soak: the simulator's servo, jaws and tissue, with joints that follow ideally.

The servo that judges set-points, brakes by itself and latches faults is the simulator's own, and so
are jaws and tissue. Only PyBullet's inertia is left out, for which a day would take ten times as
long. Beside the robot stands the link through which the controller sees it, which can go wrong.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from rst_control.config import SimulationConfig
from rst_control.kinematics import forward
from rst_control.kinematics.configuration import planning_joints
from rst_control.kinematics.robot_model import RobotModel
from rst_control.robot.setpoint_servo import Servo, ServoState
from rst_control.ros.controller.measurement_assembler import LOST_AFTER
from rst_control.simulation.pybullet_robot import servo_limits, start_joints
from rst_control.simulation.tissue import Jaws, SimulatedTissue
from rst_control.types import JOINT_COUNT, Cause, Measurement, Reason, Setpoint, frozen_array

Array = NDArray[np.float64]
STEP = 0.001  # [s] as the simulator's physics
NO_EFFORT = np.zeros(JOINT_COUNT)


class ServoRobot:
    """A RobotBackend whose time is moved on by `advance`.

    Args:
        config: Scene, limits and simulator settings.
        model: The robot.
        start: Time of the first state [s].
    """

    def __init__(self, config: SimulationConfig, model: RobotModel, start: float) -> None:
        begin = start_joints(config)
        self._start, self._steps = start, 0
        self.servo = Servo(config.simulator.servo, servo_limits(config.limits), begin)
        self.tissue = SimulatedTissue(config.scene.tissue, STEP)
        self._jaws = Jaws(
            self.tissue, config.simulator.closed_opening, config.simulator.held_opening
        )
        self._chain, self._frames = model.chain, np.empty((12, 3, 4))
        self.position, self.velocity = begin, np.zeros(JOINT_COUNT)
        self.force = np.zeros(3)

    @property
    def now(self) -> float:
        """Time of the present state [s]."""
        return self._start + self._steps * STEP

    @property
    def is_braking(self) -> bool:
        """It slows down by itself."""
        return self.servo.state is ServoState.BRAKING

    def measured_js(self) -> Measurement:
        """Present joint states and the force on the jaws."""
        return Measurement(
            position=self.position,
            velocity=self.velocity,
            effort=NO_EFFORT,
            stamp=self.now,
            force=self.force,
            gripped=self.tissue.is_held,
            fault=self.servo.fault,
            sent_to=self.servo.rest,
        )

    def servo_jp(self, setpoint: Setpoint) -> None:
        """Take one set-point of a stream; what no joint may follow raises a fault."""
        self.servo.accept(setpoint, self.now)

    def hold(self) -> None:
        """Slow down and stay."""
        self.servo.hold(self.now)

    def clear_fault(self) -> None:
        """Take set-points again, if the joints are at rest."""
        self.servo.clear_fault()

    def advance(self, seconds: float) -> None:
        """Let time pass [s]."""
        for _ in range(round(seconds / STEP)):
            self._step()

    def _step(self) -> None:
        self._steps += 1
        self.position, self.velocity = self.servo.course(self.now)
        q, opening = planning_joints(self.position)
        forward.forward(self._chain, q, self._frames)
        tip = self._frames[forward.TIP, :, 3].copy()
        self._jaws.follow(opening, tip)
        self.force = self.tissue.advance(tip)


class SensorLink:
    """What the controller sees of the robot, and what becomes of that when something breaks.

    Joint states that stop leave the last ones standing, and after a quarter of a second the robot
    counts as not connected; what is no number is dropped and named as a fault: both as in
    `rst_control.ros.controller.measurement_assembler`.

    Args:
        robot: The robot.
    """

    def __init__(self, robot: ServoRobot) -> None:
        self._robot = robot
        self._last = robot.measured_js()
        self.is_frozen = False  # no joint states come
        self.jump: Array | None = None  # (10,), [rad] by which reported joints are wrong
        self.extra: Array | None = None  # (3,), [N] by which the reported force is wrong

    def measured_js(self) -> Measurement:
        """Newest joint states with the force on the jaws."""
        if self.is_frozen:
            is_connected = self._robot.now - self._last.stamp < LOST_AFTER
            if self._last.connected is not is_connected:
                self._last = replace(self._last, connected=is_connected)
            return self._last
        self._last = self._spoilt(self._robot.measured_js())
        return self._last

    def _spoilt(self, true: Measurement) -> Measurement:
        if self.jump is not None:
            true = replace(true, position=true.position + self.jump)
        if self.extra is None:
            return true
        try:
            return replace(true, force=frozen_array(true.force + self.extra, 3))
        except ValueError as error:
            fault = Cause(Reason.TENSION_SENSOR, f"tension: {error}")
            return replace(true, force=self._last.force, fault=fault.coded)

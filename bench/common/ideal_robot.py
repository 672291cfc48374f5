# SPDX-License-Identifier: BSD-3-Clause
"""A robot without inertia on the simulator's tissue: exact set-points late, exact forces.

In PyBullet the joints stay within a hundredth of a microradian of their course, so for questions of
tension this is the same robot, stepped several times faster.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from rst_control.config import SimulationConfig
from rst_control.kinematics import forward
from rst_control.kinematics.configuration import planning_joints
from rst_control.kinematics.robot_model import load_robot
from rst_control.simulation.physics import JointReading
from rst_control.simulation.pybullet_robot import start_joints
from rst_control.simulation.tissue import Jaws, SimulatedTissue
from rst_control.types import JOINT_COUNT, Measurement, Setpoint

Array = NDArray[np.float64]
STEP = 0.001  # [s]


class LightRobot:
    """Plays set-points a fixed time late; a RobotBackend whose time is moved on by `advance`.

    Args:
        config: Scene and simulator settings.
        start: Time of the first state [s].
    """

    def __init__(self, config: SimulationConfig, start: float = 10.0) -> None:
        scene, simulator = config.scene, config.simulator
        begin = start_joints(config)
        self.now, self.fault = start, ""
        self.tissue = SimulatedTissue(scene.tissue, STEP)
        self.reading = JointReading(begin, np.zeros(JOINT_COUNT), np.zeros(JOINT_COUNT))
        self.force = np.zeros(3)
        self.sensor: Callable[[Array], Array] = lambda force: force  # what it reports of a force
        self._delay = simulator.servo.playout_delay
        self._waiting: deque[Setpoint] = deque([Setpoint(begin, np.zeros(JOINT_COUNT), start)])
        self._jaws = Jaws(self.tissue, simulator.closed_opening, simulator.held_opening)
        self._chain, self._frames = load_robot().chain, np.empty((12, 3, 4))

    @property
    def true(self) -> JointReading:
        """Joints as they are: as they are measured."""
        return self.reading

    @property
    def target(self) -> Array:
        """Where the joints should be now [rad]. Shape (10,)."""
        return self.reading.position

    def measured_js(self) -> Measurement:
        """Present joint states and the force on the jaws."""
        return Measurement(
            position=self.reading.position,
            velocity=self.reading.velocity,
            effort=self.reading.effort,
            stamp=self.now,
            force=self.sensor(self.force),
            gripped=self.tissue.is_held,
        )

    def servo_jp(self, setpoint: Setpoint) -> None:
        """Take one set-point of a stream."""
        self._waiting.append(setpoint)

    def hold(self) -> None:
        """Stay where it is."""
        self._waiting = deque([Setpoint(self.target, np.zeros(JOINT_COUNT), self.now)])

    def clear_fault(self) -> None:
        """There is none to clear."""

    def advance(self, until: float, each: Callable[[], None] = lambda: None) -> None:
        """Step until a time [s], calling `each` after every step."""
        while self.now < until - 0.5 * STEP:
            self._step()
            each()

    def close(self) -> None:
        """Nothing is open."""

    def _step(self) -> None:
        self.now += STEP
        time = self.now - self._delay
        while len(self._waiting) > 1 and self._waiting[1].stamp <= time + 1e-9:
            self._waiting.popleft()
        point = self._waiting[0]
        ahead = min(max(time - point.stamp, 0.0), 2.0 * STEP) if len(self._waiting) > 1 else 0.0
        position = point.position + ahead * point.velocity
        self.reading = JointReading(position, point.velocity, self.reading.effort)
        q, opening = planning_joints(position)
        forward.forward(self._chain, q, self._frames)
        tip = self._frames[forward.TIP, :, 3].copy()
        self._jaws.follow(opening, tip)
        self.force = self.tissue.advance(tip)

# SPDX-License-Identifier: BSD-3-Clause
"""The controller with a robot that begins at the tissue: closed jaws, pulls, and little else.

The robot is where each set-point sends it. The tissue is a spring, slack at first. The controller's
loop runs at two fifths of its rate, so that ten thousand situations can be drawn. So it takes
notice of a sensor later than the product does. Tests compare some with the full rate.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from bench.common.lockstep import START, LockStep, do_nothing
from bench.site.sensors import Sensor
from rst_control.admission.command_queue import CommandQueue
from rst_control.assembly import make_executor, make_trocar_context
from rst_control.commands.tense import choose_grasp
from rst_control.config import MotionConfig, load_motion_config
from rst_control.kinematics.configuration import planning_joints, robot_joints
from rst_control.kinematics.robot_model import load_robot
from rst_control.registration.trocar_context import ActiveTrocarContext, TrocarContext
from rst_control.types import JOINT_COUNT, Measurement, Setpoint

Array = NDArray[np.float64]
CLOSED, OPEN = 0.02, 0.06  # [rad] jaws that take hold of the tissue, and that let go of it
AT_LIMIT = 2.52  # [N] where tissue that bends is as stiff as is said of it
JAWS = 0.16  # [rad] that they open to, to save time
JAWS_SPEED, JAWS_ACCELERATION, JAWS_JERK = 3.0, 10.0, 1000.0  # [rad/s], and so on; likewise
RATE = 200.0  # [Hz] of the controller's loop


@dataclass(frozen=True)
class Spring:
    """Tissue that pulls along the way from where it was grasped."""

    stiffness: float  # [N/m]; where it bends, that at the limit of the tension
    slack: float  # [m] of way without tension
    bend: float  # [1/m] of F = a (exp(b s) - 1), after Fung; 0: it is linear

    def tension(self, way: float) -> float:
        """Tension [N] at a way from the grasp [m]."""
        taut = max(0.0, way - self.slack)
        if self.bend <= 0.0:
            return self.stiffness * taut
        soft = self.stiffness / self.bend - AT_LIMIT
        return soft * math.expm1(min(self.bend * taut, 50.0))


class SpringRobot:
    """Takes each set-point at once, and holds a spring between its jaws.

    Args:
        joints: At the start [rad]. Shape (10,).
        tip_of: Tool tip at joints (10,) [rad]: base frame, [m].
        tissue: Between its jaws.
        sensor: Reports the force.
    """

    def __init__(
        self,
        joints: Array,
        tip_of: Callable[[Array], Array],
        tissue: Spring,
        sensor: Sensor,
    ) -> None:
        self.now, self.target = START, joints
        self.force = np.zeros(3)  # [N] true
        self._velocity, self._effort = np.zeros(JOINT_COUNT), np.zeros(JOINT_COUNT)
        self._tip_of, self._tissue, self._sensor = tip_of, tissue, sensor
        self._anchor: Array | None = None
        self._was_open = True

    @property
    def tension(self) -> float:
        """What the tissue truly feels [N]."""
        return float(np.linalg.norm(self.force))

    @property
    def is_held(self) -> bool:
        """The jaws hold the tissue."""
        return self._anchor is not None

    def measured_js(self) -> Measurement:
        """Joints, and the force as the sensor has it."""
        return Measurement(
            position=self.target,
            velocity=self._velocity,
            effort=self._effort,
            stamp=self.now,
            force=self._sensor(self.now, self.force, self.is_held),
            gripped=self.is_held,
        )

    def servo_jp(self, setpoint: Setpoint) -> None:
        """Go to a set-point."""
        self.target, self._velocity = setpoint.position, setpoint.velocity
        opening = planning_joints(self.target)[1]
        if opening > OPEN:
            self._anchor, self._was_open = None, True
        elif opening < CLOSED and self._was_open:
            self._anchor, self._was_open = self._tip_of(self.target).copy(), False
        self.force = np.zeros(3) if self._anchor is None else self._pull(self._anchor)

    def _pull(self, anchor: Array) -> Array:
        way = anchor - self._tip_of(self.target)
        length = float(np.linalg.norm(way))
        pull: Array = self._tissue.tension(length) * way / max(length, 1e-9)
        return pull

    def clear_fault(self) -> None:
        """There is none to clear."""

    def close(self) -> None:
        """Nothing is open."""


class HeldTissue(LockStep):
    """Controller and robot, at the tissue from the start.

    Args:
        config: Settings.
        tissue: Between the jaws.
        sensor: Reports the force.
    """

    def __init__(self, config: MotionConfig, tissue: Spring, sensor: Sensor) -> None:
        context, joints = at_tissue(config)
        self.period = 1.0 / config.controller.rate
        active = ActiveTrocarContext(context)
        self.planner = context.planner
        self.robot = SpringRobot(joints, active.tip, tissue, sensor)
        self.executor = make_executor(config, active, self.robot.clear_fault)
        self.queue = CommandQueue(self.executor, active.verify, lambda: self.robot.now)
        self.peak = 0.0  # [N] true tension
        self.invalid_reason = ""  # why its reading was not believed

    def tick(self, each: Callable[[], None] = do_nothing) -> None:
        """One period of the control loop."""
        self.robot.now += self.period
        self.executor.heartbeat(self.robot.now)  # of the voice node, which is well
        setpoint = self.executor.tick(self.robot.now, self.robot.measured_js())
        if setpoint is not None:
            self.robot.servo_jp(setpoint)
        self.peak = max(self.peak, self.robot.tension)
        measured = self.executor.snapshot.measurement
        if measured is not None and not self.invalid_reason:
            self.invalid_reason = measured.tension_invalid_reason
        each()


@lru_cache(maxsize=64)
def at_tissue(config: MotionConfig) -> tuple[TrocarContext, Array]:
    """Planning for these settings, and joints (10,) [rad] at the tissue with open jaws."""
    context = make_trocar_context(config, load_robot())
    grasp = choose_grasp(context.planner, np.array(config.scene.home))
    q = grasp.reach[-1].end if grasp.reach else np.array(config.scene.home)
    return context, robot_joints(q, config.controller.jaws.open)


@lru_cache(maxsize=64)
def site(stiffest: float, is_bound: bool, rate: float = RATE) -> MotionConfig:
    """Settings of a site whose tissue is at most so stiff [N/m].

    Args:
        stiffest: As the site states it.
        is_bound: Whether the site leaves the sensor's gain unchecked.
        rate: Of the controller's loop [Hz].
    """
    config = load_motion_config()
    tension = replace(
        config.controller.tension,
        blind_stiffness=stiffest,
        gain="unchecked" if is_bound else "checked",
    )
    sensors = config.controller.watchdogs.sensors
    sensors = replace(sensors, slack_way=min(sensors.slack_way, tension.maximum / stiffest))
    watchdogs = replace(config.controller.watchdogs, sensors=sensors)
    jaws = replace(
        config.controller.jaws,
        open=JAWS,
        speed=JAWS_SPEED,
        acceleration=JAWS_ACCELERATION,
        jerk=JAWS_JERK,
    )
    controller = replace(
        config.controller, tension=tension, watchdogs=watchdogs, jaws=jaws, rate=rate
    )
    return replace(config, controller=controller)

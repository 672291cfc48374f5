# SPDX-License-Identifier: BSD-3-Clause
"""Controller, bridge and the drivers' strict simulation in one process and in lock-step.

No ROS, no real time. Time goes on only by `tick`, one period of the control loop. What ROS itself
takes from process to process, some tenths of a millisecond, is left out.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any, Literal

import numpy as np

from bench.common.lockstep import START, Array, LockStep, do_nothing
from bench.common.quiet import quiet
from rst_control.admission.command_queue import CommandQueue
from rst_control.assembly import make_executor
from rst_control.config import CONFIG_FOLDER, URDF_FILE, MotionConfig, load_simulation_config
from rst_control.config.plant import PlantConfig
from rst_control.kinematics.robot_model import load_robot
from rst_control.kinova.brake_plan import LastCourse
from rst_control.kinova.bridge import Bridge
from rst_control.kinova.config import KinovaConfig, load_kinova_config
from rst_control.kinova.feedback import FeedbackReader
from rst_control.kinova.guard import StopGuard
from rst_control.kinova.homing import home
from rst_control.kinova.stand_in import KinovaRobot, StandInConfig, as_driven, load_stand_in_config
from rst_control.registration.trocar_context import ActiveTrocarContext, TrocarContext
from rst_control.robot.backend import RobotBackend
from rst_control.simulation.pybullet_robot import PybulletRobot
from rst_control.tension.gravity_check import RestTorques
from rst_control.types import Measurement, Setpoint
from typed_config import load_config, load_yaml, overlaid

Loss = Literal["controller", "bridge", "feedback"]
STEP = 0.001  # [s] of the physics
FILES = ("limits", "rcm", "scene", "controller", "collision")


def kinova_motion(over: Mapping[str, Any] = MappingProxyType({})) -> MotionConfig:
    """Settings of the controller as launch/kinova.launch has them, with some changed.

    Its sensor is simulated and reads right, so the gain counts as checked.
    """
    files: dict[str, Any] = {name: load_yaml(CONFIG_FOLDER / f"{name}.yaml") for name in FILES}
    files["limits"] = load_yaml(CONFIG_FOLDER / "kinova_limits.yaml")
    merged = overlaid(files, load_yaml(CONFIG_FOLDER / "kinova_controller.yaml"))
    merged = overlaid(merged, {"controller": {"tension": {"gain": "checked"}}})
    return load_config(MotionConfig, overlaid(merged, over), "kinova settings")


def _quick_to_home(config: StandInConfig) -> StandInConfig:
    """The same drivers with a tool that homes in seconds: that is not what is measured."""
    return replace(config, tool=replace(config.tool, homing_speed=1.4, homing_dwell=0.05))


class BridgeLink(RobotBackend):
    """The bridge with the clock of its rig."""

    def __init__(self, rig: KinovaRig) -> None:
        self._rig = rig

    def measured_js(self) -> Measurement | None:
        """What the bridge says."""
        return self._rig.bridge.measured

    def servo_jp(self, setpoint: Setpoint) -> None:
        """Lead the bridge."""
        self._rig.bridge.servo_jp(setpoint, self._rig.now)

    def hold(self) -> None:
        """Slow down and stay."""
        self._rig.bridge.hold(self._rig.now)

    def clear_fault(self) -> None:
        """Take set-points again."""
        self._rig.bridge.clear_fault(self._rig.now)


class KinovaRig(LockStep):
    """The whole way from a command to the joints; a context manager.

    Args:
        motion: Settings of the controller.
        bridge: Settings of the bridge; its limits are those of `motion`.
        plant: What is not ideal; None: all is.
        feedback_rate: Of the arm's driver [Hz].
    """

    def __init__(
        self,
        motion: MotionConfig,
        bridge: KinovaConfig | None = None,
        plant: PlantConfig | None = None,
        feedback_rate: float = 40.0,
    ) -> None:
        self.config, self.period = motion, 1.0 / motion.controller.rate
        stand_in, simulation = _quick_to_home(load_stand_in_config()), load_simulation_config()
        self._limits = simulation.limits  # the driver's own layers
        settings = replace(
            simulation,
            scene=motion.scene,
            simulator=as_driven(simulation.simulator, stand_in.tool),
        )
        if plant is not None:
            simulator = replace(settings.simulator, plant="lab")
            settings = replace(settings, simulator=simulator, plant=plant)
        with quiet():
            self.robot = PybulletRobot(settings, start=START)
        self.drivers = KinovaRobot(stand_in, self._limits, self.robot)
        kinova = replace(bridge or load_kinova_config(), limits=motion.limits, scene=motion.scene)
        torques = RestTorques(
            kinova.torques, URDF_FILE.read_text(encoding="utf-8"), motion.scene.gravity
        )
        self.bridge = Bridge(kinova, self, torques)
        self.link: RobotBackend = BridgeLink(self)  # as the controller reaches it
        arm, tool = kinova.bridge.arm, kinova.bridge.tool
        self._read_arm = FeedbackReader(arm.joints, (1.0,) * 7, kinova.first_turns)
        self._read_tool = FeedbackReader(tool.joints, tool.signs, None)
        self.arm_names, self._tool_names = arm.joints, tool.joints
        self._steps, self._is_sending = 0, False
        self._feedback = round(1.0 / (feedback_rate * STEP))  # steps between two states of the arm
        self._reported_course: LastCourse | None = None  # with the last beat of the bridge
        self.guard = StopGuard(kinova.bridge)
        self.lost: Loss | None = None  # what fails from now on
        context = ActiveTrocarContext(TrocarContext(motion, load_robot()))
        self.planner, self._gauge = context.current.planner, context.trocar_pose
        self.executor = make_executor(motion, context, lambda: self.bridge.clear_fault(self.now))
        self.queue = CommandQueue(self.executor, context.verify, lambda: self.now)

    # As the bridge's hardware.

    def send_speeds(self, speeds: Array) -> None:
        """Turn the arm's joints at these speeds [rad/s]."""
        self.drivers.driver.take_speeds(dict(enumerate(np.float32(speeds).tolist())))

    def send_tool(self, joints: Array) -> None:
        """Send pitch and jaws to these angles [rad]."""
        self.drivers.tool.take_command(joints.tolist())

    def stop(self) -> None:
        """Stop the arm."""
        self.drivers.driver.take_stop()

    def clear_faults(self) -> None:
        """Ask the arm to clear its faults."""
        self.drivers.driver.take_clear_faults()

    # Time.

    @property
    def now(self) -> float:
        """Time [s]."""
        return self.robot.now

    def tick(self, each: Callable[[], None] = do_nothing) -> None:
        """One period of the control loop; `each` is called after every step of the physics."""
        setpoint = self.executor.tick(self.now, self.link.measured_js())
        if self.lost == "controller":
            setpoint = None
        elif setpoint is not None:
            self.link.servo_jp(setpoint)
        elif self._is_sending:
            self.link.hold()
        self._is_sending = setpoint is not None and self.lost != "controller"
        for _ in range(round(self.period / STEP)):
            self.step()
            each()

    def step(self) -> None:
        """One step of the physics, and what drivers and bridge do in it."""
        self._steps += 1
        self.drivers.step()
        self.robot.step()
        now, count = self.now, self._steps
        self.bridge.on_force(self.robot.force, now)
        if count % 8 == 0:
            self._report_tool(now)
        is_silent = self.lost in ("feedback", "bridge")  # of the last nobody would hear
        if count % self._feedback == 0 and not is_silent:
            self._report_arm(now)
        if count % 20 == 0 and self.guard.hears_bridge(now):
            self.bridge.on_guard(now)
        if count % 5 == 0 and self.lost != "bridge":
            self.bridge.step(now)
            self._beat(now)
        if count % 5 == 0:
            self._guarded(now)

    def _beat(self, now: float) -> None:
        """One beat for the guard, with each velocity and every 20 ms, as the bridge's node."""
        if self.bridge.last_course is not self._reported_course or self._steps % 20 == 0:
            self._reported_course = self.bridge.last_course
            self.guard.heard(now, self._reported_course)

    def _guarded(self, now: float) -> None:
        """One round of the guard."""
        speeds = self.guard.speeds_due(now)
        if speeds is not None:
            self.send_speeds(speeds)
        elif self.guard.is_stop_due(now):
            self.stop()

    def _report_arm(self, now: float) -> None:
        """The arm's own state and its joints; its limits where the bridge does not know them."""
        report, arm, watch = (
            self.drivers.arm_report(),
            self.drivers.arm_feedback(),
            self.bridge.watch,
        )
        if report is None or arm is None:
            return
        watch.limits = watch.limits or self.drivers.soft_limits()
        self.bridge.on_arm_report(report)
        values = {"position": arm.position, "velocity": arm.velocity, "effort": arm.effort}
        self.bridge.on_arm(self._read_arm.read(self.arm_names, values, now))

    def _report_tool(self, now: float) -> None:
        self.bridge.tool.update_state(int(self.drivers.tool.state))
        position = self.drivers.tool_feedback()
        if position is not None:
            values = {"position": position, "velocity": np.zeros(len(position)), "effort": ()}
            self.bridge.on_tool(self._read_tool.read(self._tool_names, values, now))

    # Commands.

    def home(self) -> None:
        """Home the tool, as robot/home_tool does."""

        def request(message: str) -> bool:
            answers: list[bool] = []
            self.drivers.tool.request(message, answers.append)
            self.until(lambda: bool(answers))
            return answers == [True]

        def wait(condition: Callable[[], bool], limit: float) -> bool:
            return self.until(condition, limit)

        home(request, self.bridge.tool, self.send_tool, wait)
        self.bridge.tool.is_homed = True
        self.run(0.3)

    # What truly is.

    @property
    def rcm_error(self) -> float:
        """Distance of the shaft from the trocar [m]."""
        return self._gauge(self.robot.true.position).error

    @property
    def speed(self) -> float:
        """Of the fastest joint of the arm [rad/s]."""
        return float(np.abs(self.robot.true.velocity[:7]).max())

    @property
    def tip(self) -> Array:
        """Tool tip, base frame, [m]. Shape (3,)."""
        return self.tip_at(self.robot.true.position)

    @property
    def tension(self) -> float:
        """Pull of the tissue [N]."""
        return float(np.linalg.norm(self.robot.true_force))

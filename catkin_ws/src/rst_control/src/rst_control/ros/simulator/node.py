# SPDX-License-Identifier: BSD-3-Clause
"""The simulated robot as a ROS node; how it is commanded is up to its interface, set by `mode`."""

from __future__ import annotations

import logging
import sys
import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Protocol

import numpy as np
import rospy
from rosgraph_msgs.msg import Clock
from std_srvs.srv import Trigger, TriggerResponse

from rst_control.config import URDF_FILE, SimulationConfig
from rst_control.config.plant import LatenessConfig
from rst_control.errors import RstError
from rst_control.kinova.stand_in import StandInConfig, as_driven
from rst_control.robot.setpoint_servo import ServoState
from rst_control.ros.common.priority import ask_for_priority, spare_the_loop
from rst_control.ros.kinova.stand_in_interface import DriverInterface, other_driver
from rst_control.ros.rospy_patches.message_limits import limit_messages
from rst_control.ros.rospy_patches.nonblocking_publish import publish_without_waiting
from rst_control.ros.simulator.diagnostics import SimulatorDiagnostics, publish_places
from rst_control.ros.simulator.fast_interface import SetpointInterface
from rst_control.ros.simulator.markers import SimulatorMarkers
from rst_control.ros.simulator.messages import Stamper
from rst_control.ros.simulator.pace import SimulationPace
from rst_control.ros.simulator.pictures import SimulatorPictures
from rst_control.simulation.pybullet_robot import PybulletRobot
from rst_control.simulation.rendering.state import SceneState
from rst_control.simulation.rendering.trail import Trail
from rst_control.simulation.rendering.worker import SceneLostError
from typed_config import ConfigError, load_config
from typed_config.ros.known_publishers import KnownPublishers
from typed_config.ros.launch_settings import launch_settings
from typed_config.ros.starting import WRONG, starting, wait_for_clock

log = logging.getLogger("rosout.rst_control.simulator")

JOB_LIMIT = 5.0  # [s] for the loop to take up what a service asks for
FINE_RATE = 1000.0  # [Hz] of the physics, from which the figures of motion are measured
COARSE = "physics at %g Hz, below %g Hz: the shaft leaves the trocar further than a robot's would"
NOT_OF_SIMULATION = ("kinova", "urdf", "rcm", "controller", "collision")  # drivers', controller's
IN_TIME = LatenessConfig(
    command_delay=0.0, command_jitter=0.0, feedback_delay=0.0, feedback_jitter=0.0
)
STRICT = "kinova_strict"  # the mode that stands in for the real drivers
DRIVEN = (
    "the simulated drivers cannot start: %s is a driver of the same name; end the drivers first, "
    "or use another ROS master"
)


class RobotInterface(Protocol):
    """How the robot is commanded and what it publishes."""

    def lead(self) -> None:
        """Do what is due before the next steps of the physics."""
        ...

    def publish(self) -> None:
        """Publish the state of the robot after them."""
        ...


class SimulatorNode:
    """Owns the simulated robot; callbacks only leave work for its loop.

    Args:
        config: Settings of the simulation.
        urdf: Model of the robot.
        stand_in: Settings of the drivers that it stands in for; None: it takes set-points.
    """

    def __init__(
        self, config: SimulationConfig, urdf: Path, stand_in: StandInConfig | None = None
    ) -> None:
        simulator = config.simulator
        self._is_real_time = simulator.real_time_factor == 1.0
        start = time.monotonic() if self._is_real_time else 1.0
        self.robot = PybulletRobot(config, urdf, start)
        self._steps = round(simulator.physics_rate / simulator.publish_rate)
        if simulator.physics_rate < FINE_RATE:
            log.warning(COARSE, simulator.physics_rate, FINE_RATE)
        self._catch_up = simulator.catch_up
        self._stamper = Stamper(self._is_real_time)
        self._jobs: deque[Callable[[], None]] = deque()
        self._clock = None if self._is_real_time else rospy.Publisher("/clock", Clock, queue_size=1)
        self._known = KnownPublishers()
        self._interface = self._make_interface(config, stand_in)
        self._service = rospy.Service("robot/reset_tissue", Trigger, self._on_reset)
        self._trail = Trail()
        self._pictures = SimulatorPictures(config, urdf, self._copy_state)
        self._markers = SimulatorMarkers(config.scene.tissue, self._copy_state)
        period = self._steps * self.robot.time_step
        self.pace = SimulationPace(period, simulator.real_time_factor, time.monotonic, time.sleep)
        self._diagnostics = SimulatorDiagnostics(
            self.robot, self.pace, period, config.scene, self._known, simulator.led_by
        )
        self._places = publish_places(config.scene)

    def run(self) -> None:
        """Simulate until the node is shut down."""
        if self._is_real_time:
            self._diagnostics.priority = ask_for_priority()
            self.robot.skip(time.monotonic() - self.robot.now)
        self.pace.start()
        while not rospy.is_shutdown():
            behind = self.pace.wait()
            if behind > self._catch_up and not rospy.is_shutdown():
                self._fall_behind(behind)
            while self._jobs:
                self._jobs.popleft()()
            self._interface.lead()
            for _ in range(self._steps):
                self.robot.step()
            self._trail.add(self.robot.tip)
            self._publish()

    def close(self) -> None:
        """Leave the physics, end the drawing processes and the thread that shows the tissue."""
        self._markers.close()
        self._pictures.close()
        self.robot.close()

    def _make_interface(
        self, config: SimulationConfig, stand_in: StandInConfig | None
    ) -> RobotInterface:
        robot, jobs, stamper = self.robot, self._jobs, self._stamper
        if stand_in is None:
            led_by, is_lab = config.simulator.led_by, robot.plant is not None
            return SetpointInterface(
                robot,
                jobs,
                stamper,
                self._is_real_time,
                self._known,
                led_by,
                config.plant.lateness if is_lab else IN_TIME,
                config.plant.seed,
            )
        return DriverInterface(robot, jobs, stamper, config, stand_in)

    def _publish(self) -> None:
        self._interface.publish()
        if self._clock is not None:
            self._clock.publish(Clock(rospy.Time(*self._stamper.split(self.robot.now))))
        if self._diagnostics.is_due():
            self._diagnostics.publish(self._known.status("robot", "simulator"))

    def _fall_behind(self, behind: float) -> None:
        """Too late to make up for: at rest, time is given up; in motion the robot brakes first."""
        if self._is_real_time:
            if self.robot.servo_state is not ServoState.HOLDING:
                self.robot.fail(f"the simulation fell {behind:.2f} s behind real time")
                return
            self.robot.skip(behind)
        self.pace.give_up(behind)
        log.warning("gave up %.2f s: the simulation could not keep up", behind)

    def _on_reset(self, _: object) -> TriggerResponse:
        self._in_loop(self.robot.tissue.reset)
        return TriggerResponse(True, "the tissue lies as at the start")

    def _copy_state(self) -> SceneState:
        states: list[SceneState] = []
        robot = self.robot
        self._in_loop(
            lambda: states.append(
                SceneState(
                    joints=np.array(robot.reading.position),
                    nodes=robot.tissue.nodes,
                    held=robot.tissue.held_node,
                    tip=np.array(robot.tip),
                    force=np.array(robot.force),
                    trail=self._trail.points,
                )
            )
        )
        return states[0]

    def _in_loop(self, job: Callable[[], None]) -> None:
        """Let the loop do something between two steps, and wait for it.

        Raises:
            TimeoutError: The loop does not run.
        """
        done = threading.Event()

        def run() -> None:
            job()
            done.set()

        self._jobs.append(run)
        if not done.wait(JOB_LIMIT):
            raise TimeoutError("the simulation does not run")


def read_parameters(given: dict[str, object]) -> tuple[SimulationConfig, StandInConfig | None]:
    """Settings of the simulation, and of the drivers that it stands in for where it does.

    Raises:
        ConfigError: A key is unknown, missing or out of range; names it.
    """
    rest = {key: value for key, value in given.items() if key not in NOT_OF_SIMULATION}
    config = load_config(SimulationConfig, rest, "simulator parameters")
    if config.simulator.mode != STRICT:
        return config, None
    stand_in = load_config(StandInConfig, given.get("kinova", {}), "simulator parameters: kinova")
    simulator = as_driven(config.simulator, stand_in.tool)
    return replace(config, simulator=simulator), stand_in


def main() -> None:
    """Run the simulator node."""
    limit_messages()
    publish_without_waiting()
    refusals = (ConfigError, RstError, SceneLostError, OSError)
    with starting("robot", __doc__, needs_clock=False, refusals=refusals, launch="robot.launch"):
        given = launch_settings()
        config, stand_in = read_parameters(given)
        if stand_in is not None and (driver := other_driver(stand_in)):
            rospy.logfatal(DRIVEN, driver)
            sys.exit(WRONG)
        if config.simulator.real_time_factor == 1.0:
            wait_for_clock()  # else the clock is that of this node
        node = SimulatorNode(config, Path(str(given.get("urdf", URDF_FILE))), stand_in)
    spare_the_loop()
    try:
        node.run()
    except rospy.ROSInterruptException:
        pass
    finally:
        node.close()

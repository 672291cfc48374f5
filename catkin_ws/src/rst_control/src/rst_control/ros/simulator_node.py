# SPDX-License-Identifier: BSD-3-Clause
"""The simulated robot as a ROS node: set-points in; joint states, tension, grip, faults out."""

from __future__ import annotations

import gc
import logging
import sys
import threading
import time
from collections import deque
from collections.abc import Callable

import numpy as np
import rospy
from geometry_msgs.msg import WrenchStamped
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool, Empty, String
from std_srvs.srv import Trigger, TriggerResponse

from rst_control.backends.pybullet_robot import PybulletRobot
from rst_control.backends.scene_server import SceneState
from rst_control.backends.scene_worker import SceneLostError
from rst_control.backends.servo import ServoState
from rst_control.backends.trail import Trail
from rst_control.config import SimulationConfig
from rst_control.errors import RstError
from rst_control.ros.intake import guard_intake
from rst_control.ros.priority import ask_for_priority
from rst_control.ros.simulator_diagnostics import SimulatorDiagnostics, broadcast_places
from rst_control.ros.simulator_markers import SimulatorMarkers
from rst_control.ros.simulator_messages import RawJointState, Stamper, StateWriter
from rst_control.ros.simulator_pace import Pace
from rst_control.ros.simulator_pictures import SimulatorPictures
from rst_control.ros.wire import BadMessage, JointStateReader
from rst_control.types import JOINTS, Setpoint
from typed_config import ConfigError, load_config

log = logging.getLogger("rosout.rst_control.simulator")

SWITCH_INTERVAL = 1e-4  # [s] how long another Python thread may keep the interpreter from the loop
JOB_LIMIT = 5.0  # [s] for the loop to take up what a service asks for
FINE_RATE = 1000.0  # [Hz] of the physics, from which the figures of motion are measured
COARSE = "physics at %g Hz, below %g Hz: the shaft leaves the trocar further than a robot's would"
MOST_JOBS = 1000  # that wait for the loop; set-points beyond are missed, and the servo holds
NO_STAMP = 0.0  # set-points sent by hand carry no stamp


class SimulatorNode:
    """Owns the simulated robot; callbacks only leave work for its loop.

    Args:
        config: Settings of the simulation.
    """

    def __init__(self, config: SimulationConfig) -> None:
        simulator = config.simulator
        self._is_real_time = simulator.real_time_factor == 1.0
        self.robot = PybulletRobot(config, start=time.monotonic() if self._is_real_time else 1.0)
        self._steps = round(simulator.physics_rate / simulator.publish_rate)
        if simulator.physics_rate < FINE_RATE:
            log.warning(COARSE, simulator.physics_rate, FINE_RATE)
        self._catch_up = simulator.catch_up
        self._stamper = Stamper(self._is_real_time)
        self._writer, self._reader = StateWriter(self._stamper), JointStateReader(JOINTS)
        self._jobs: deque[Callable[[], None]] = deque()
        self._told_grip: bool | None = None
        self._told_fault: str | None = None
        self._advertise()
        self._trail = Trail()
        self._pictures = SimulatorPictures(config, self._copy_state)
        self._markers = SimulatorMarkers(config.scene.tissue, self._copy_state)
        period = self._steps * self.robot.time_step
        self.pace = Pace(period, simulator.real_time_factor, time.monotonic, time.sleep)
        self._diagnostics = SimulatorDiagnostics(self.robot, self.pace, period, config.scene)
        self._places = broadcast_places(config.scene)

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
            for _ in range(self._steps):
                self.robot.step()
            self._trail.add(self.robot.tip)
            self._publish()

    def close(self) -> None:
        """Leave the physics, end the drawing processes and the thread that shows the tissue."""
        self._markers.close()
        self._pictures.close()
        self.robot.close()

    def _advertise(self) -> None:
        self._joints = rospy.Publisher("joint_states", JointState, queue_size=5, tcp_nodelay=True)
        self._tension = rospy.Publisher(
            "robot/tension", WrenchStamped, queue_size=5, tcp_nodelay=True
        )
        self._gripped = rospy.Publisher("robot/gripped", Bool, queue_size=10, latch=True)
        self._fault = rospy.Publisher("robot/fault", String, queue_size=10, latch=True)
        self._clock = None if self._is_real_time else rospy.Publisher("/clock", Clock, queue_size=1)
        self._subscribers = [
            rospy.Subscriber("robot/servo_jp", RawJointState, self._on_setpoint, tcp_nodelay=True),
            rospy.Subscriber("robot/hold", Empty, self._on(self.robot.hold), queue_size=1),
            rospy.Subscriber(
                "robot/clear_fault", Empty, self._on(self.robot.clear_fault), queue_size=1
            ),
        ]
        self._service = rospy.Service("robot/reset_tissue", Trigger, self._on_reset)

    def _publish(self) -> None:
        robot, now = self.robot, self.robot.now
        self._joints.publish(self._writer.joints(now, robot.reading))
        self._tension.publish(self._writer.wrench(now, robot.force))
        if self._clock is not None:
            self._clock.publish(Clock(rospy.Time(*self._stamper.split(now))))
        if robot.tissue.is_held != self._told_grip:
            self._told_grip = robot.tissue.is_held
            self._gripped.publish(Bool(self._told_grip))
        if robot.fault != self._told_fault:
            self._told_fault = robot.fault
            self._fault.publish(String(self._told_fault))
            if self._told_fault:
                log.warning("fault: %s", self._told_fault)
        if self._diagnostics.is_due():
            self._stamper.follow_wall_clock()
            self._diagnostics.publish()

    def _fall_behind(self, behind: float) -> None:
        """Too late to make up for: at rest, time is given up; in motion the robot brakes first."""
        if self._is_real_time:
            if self.robot.servo_state is not ServoState.HOLDING:
                self.robot.fail(f"the simulation fell {behind:.2f} s behind real time")
                return
            self.robot.skip(behind)
        self.pace.give_up(behind)
        log.warning("gave up %.2f s: the simulation could not keep up", behind)

    def _on(self, job: Callable[[], None]) -> Callable[[Empty], None]:
        return lambda _: self._jobs.append(job)

    def _on_setpoint(self, message: RawJointState) -> None:
        if len(self._jobs) < MOST_JOBS:
            self._jobs.append(lambda: self._take(message.raw))

    def _take(self, raw: bytes) -> None:
        self._reader.reset()  # the servo itself judges the order of stamps
        try:
            sample = self._reader(raw)
        except BadMessage as error:
            self.robot.fail(f"bad set-point: {error}")
            return
        known = self._is_real_time and sample.stamp > NO_STAMP
        stamp = self._stamper.simulated(sample.stamp) if known else self.robot.now
        self.robot.servo_jp(Setpoint(sample.position, sample.velocity, stamp))

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


def main() -> None:
    """Run the simulator node."""
    guard_intake()
    rospy.init_node("robot")
    try:
        config = load_config(SimulationConfig, rospy.get_param("~", {}), "simulator parameters")
        node = SimulatorNode(config)
    except (ConfigError, RstError, SceneLostError, FileNotFoundError) as error:
        rospy.logfatal(f"the simulator cannot start: {error}; launch/robot.launch starts it")
        sys.exit(2)
    sys.setswitchinterval(SWITCH_INTERVAL)
    gc.collect()
    gc.freeze()
    try:
        node.run()
    except rospy.ROSInterruptException:
        pass
    finally:
        node.close()

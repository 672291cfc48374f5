# SPDX-License-Identifier: BSD-3-Clause
"""The bridge to the real robot as a ROS node: towards the controller as the simulated robot."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future

import numpy as np
import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import WrenchStamped
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool, Empty, String
from std_srvs.srv import Trigger, TriggerResponse

from rst_control.errors import RstError
from rst_control.kinova.brake_plan import LastCourse
from rst_control.kinova.bridge import Bridge
from rst_control.kinova.config import BEAT_PERIOD, KinovaConfig, require_drivable
from rst_control.kinova.homing import NotAllowed, home
from rst_control.msg import BridgeBeat
from rst_control.ros.common.priority import ask_for_priority, spare_the_loop
from rst_control.ros.common.raw_messages import RawJointState
from rst_control.ros.common.republisher import Due, Repeated
from rst_control.ros.common.serialization import BadMessage, JointStateReader
from rst_control.ros.common.wall_clock import ArrivalOffset, RosClock
from rst_control.ros.kinova.arm_report import ArmFacts
from rst_control.ros.kinova.beat import beat_message
from rst_control.ros.kinova.hardware import KinovaHardware
from rst_control.ros.rospy_patches.message_limits import limit_messages
from rst_control.ros.rospy_patches.nonblocking_publish import publish_without_waiting
from rst_control.tension.gravity_check import RestTorques
from rst_control.types import (
    BASE,
    JOINTS,
    Cause,
    Measurement,
    Reason,
    Setpoint,
    Vector,
    robot_fault,
)
from typed_config import ConfigError, load_config
from typed_config.ros.known_publishers import KnownPublishers
from typed_config.ros.launch_settings import launch_settings
from typed_config.ros.private_settings import robot_description
from typed_config.ros.starting import starting

REPEAT_PERIOD = 0.5  # [s] between words on fault and grip where nothing but the wording changes
DIAGNOSTICS_PERIOD = 1.0  # [s]
ANSWER_TIME = 2.0  # [s] for the controller to say whether the tool may be homed
NOBODY_KNOWS = (
    "whether the tool is outside the patient, is not known: the controller does not answer"
)
MAX_JOBS = 1000  # that wait for the loop; set-points beyond are missed
STILL = np.zeros(len(JOINTS))


class KinovaBridgeNode:
    """Owns the bridge; callbacks only leave work for its loop.

    Args:
        config: Settings.
        description: URDF text of the robot.

    Raises:
        RobotModelError: The URDF is not this robot's, or says another way of gravity.
    """

    def __init__(self, config: KinovaConfig, description: str) -> None:
        self._config = config.bridge
        self._known = KnownPublishers()
        self._hardware = KinovaHardware(config.bridge, config.first_turns, self._known)
        torques = RestTorques(config.torques, description, config.scene.gravity)
        self._bridge = Bridge(config, self._hardware, torques)
        self._clock, self._reader = RosClock(), JointStateReader(JOINTS)
        self._ahead = ArrivalOffset(self._clock.ahead)  # of set-points
        self._jobs: deque[Callable[[], None]] = deque()
        self._published: Measurement | None = None
        self._told_force: Vector | None = None
        self._grip: Repeated[bool] = Repeated(REPEAT_PERIOD)
        self._last_fault: Repeated[str] = Repeated(REPEAT_PERIOD, lambda a, b: bool(a) is bool(b))
        self._last_rest: Repeated[Vector] = Repeated(REPEAT_PERIOD, np.array_equal)
        self._beat_due, self._diagnostics_due = Due(BEAT_PERIOD), Due(DIAGNOSTICS_PERIOD)
        self._published_course: LastCourse | None = None  # with the last beat
        self._homing, self._is_closing = threading.Lock(), False
        self._latest = 0.0
        self._advertise()
        self._subscribe()

    def run(self) -> None:
        """Lead the robot until the node is shut down, then bring it to rest."""
        priority = ask_for_priority()
        rospy.loginfo("kinova bridge ready (priority: %s)", priority)
        period = 1.0 / self._config.rate
        due = time.monotonic()
        while not rospy.is_shutdown():  # to be closed is not yet to be shut down
            now = time.monotonic() if self._is_closing else self._round()
            due += period
            if due < now:  # rounds that were missed are not made up for
                self._latest = max(self._latest, now - due)
                due = now
            time.sleep(max(0.0, due - time.monotonic()))

    def close(self) -> None:
        """Brake the arm, stop it, send nothing else; may come in the midst of a round.

        The loop does nothing meanwhile. It would lead the arm on, and the guard would take its
        last beat for that of an arm that moves.
        """
        self._is_closing = True
        plan = self._bridge.brake_plan(self._config.arm.period)
        self._hardware.close(plan, lambda: self._beat.publish(BridgeBeat()))

    def _round(self) -> float:
        for _ in range(len(self._jobs)):
            self._jobs.popleft()()
        now = time.monotonic()
        self._bridge.step(now)
        self._publish_state(now)
        last = self._bridge.last_course
        if self._beat_due(now) or last is not self._published_course:
            self._published_course = last
            self._beat.publish(beat_message(last, now))
        if self._diagnostics_due(now):
            self._diagnose()
        return now

    def _advertise(self) -> None:
        newest = {"tcp_nodelay": True}
        self._joints = rospy.Publisher("joint_states", JointState, queue_size=5, **newest)
        self._tension = rospy.Publisher("robot/tension", WrenchStamped, queue_size=5, **newest)
        self._rest = rospy.Publisher("robot/setpoint_js", JointState, queue_size=10, latch=True)
        self._gripped = rospy.Publisher("robot/gripped", Bool, queue_size=10, latch=True)
        self._fault = rospy.Publisher("robot/fault", String, queue_size=10, latch=True)
        self._beat = rospy.Publisher("kinova_bridge/beat", BridgeBeat, queue_size=1, **newest)
        self._diagnostics = rospy.Publisher("/diagnostics", DiagnosticArray, queue_size=5)
        self._ask = rospy.ServiceProxy("rst_control/may_home_tool", Trigger)
        self._service = rospy.Service("robot/home_tool", Trigger, self._on_home)

    def _subscribe(self) -> None:
        bridge, newest = self._bridge, {"tcp_nodelay": True, "queue_size": 1}
        known, by = self._known.subscribe, self._config.believed
        self._hardware.listen(
            lambda feedback: self._jobs.append(lambda: bridge.on_arm(feedback)),
            lambda feedback: self._jobs.append(lambda: bridge.on_tool(feedback)),
            lambda state: self._jobs.append(lambda: bridge.tool.update_state(state)),
            lambda report: self._jobs.append(lambda: bridge.on_arm_report(report)),
        )
        watch, arm = bridge.watch, self._config.arm
        self._facts = ArmFacts(
            arm.namespace,
            lambda: arm.reports_limits and watch.limits is None,
            lambda limits: self._jobs.append(lambda: setattr(watch, "limits", limits)),
        )
        self._subscribers = [
            known(
                "robot/servo_jp", RawJointState, self._on_setpoint, by.controller, tcp_nodelay=True
            ),
            known("robot/hold", Empty, self._on(bridge.hold), by.controller, **newest),
            known(
                "robot/clear_fault", Empty, self._on(bridge.clear_fault), by.controller, **newest
            ),
            known("kinova_guard/alive", Empty, self._on(bridge.on_guard), by.guard, **newest),
            known("robot/tension_sensor", WrenchStamped, self._on_tension, by.sensors, **newest),
            known(
                "robot/jaw_contact",
                Bool,
                lambda message: self._jobs.append(lambda: bridge.on_contact(message.data)),
                by.sensors,
                **newest,
            ),
        ]

    def _on(self, job: Callable[[float], None]) -> Callable[[Empty], None]:
        def on_message(_: Empty) -> None:
            arrived = time.monotonic()
            self._jobs.append(lambda: job(arrived))

        return on_message

    def _on_setpoint(self, message: RawJointState) -> None:
        if len(self._jobs) < MAX_JOBS:
            ahead = self._ahead()
            if ahead is not None:
                self._jobs.append(lambda: self._take(message.raw, ahead))

    def _take(self, raw: bytes, ahead: float) -> None:
        self._reader.reset()  # the servo itself judges the order of stamps
        now = time.monotonic()
        try:
            sample = self._reader(raw, ahead)
        except BadMessage as error:
            words = f"bad set-point: {error}"
            self._bridge.fail(Cause(Reason.SETPOINT_REFUSED, words).coded, now)
            return
        self._bridge.servo_jp(Setpoint(sample.position, sample.velocity, sample.stamp), now)

    def _on_tension(self, message: WrenchStamped) -> None:
        f, now = message.wrench.force, time.monotonic()
        force = np.array([f.x, f.y, f.z])
        if np.isfinite(force).all():  # else it counts as not having come
            self._jobs.append(lambda: self._bridge.on_force(force, now))

    def _on_home(self, _: object) -> TriggerResponse:
        if not self._homing.acquire(blocking=False):
            return TriggerResponse(False, "OpenRST is being homed already")
        try:
            self._may_home()
            hardware = self._hardware
            words = home(hardware.request, self._bridge.tool, hardware.send_tool, _wait)
            self._jobs.append(lambda: setattr(self._bridge.tool, "is_homed", True))
        except (RstError, rospy.ServiceException, rospy.ROSException) as error:
            return TriggerResponse(False, str(error))
        finally:
            self._homing.release()
        return TriggerResponse(True, words)

    def _may_home(self) -> None:
        """Ask the controller, then take the tool out of service.

        Raises:
            NotAllowed: Says why.
        """
        try:
            self._ask.wait_for_service(ANSWER_TIME)
            answer = self._ask()
        except (rospy.ServiceException, rospy.ROSException) as error:
            raise NotAllowed(f"{NOBODY_KNOWS} ({error})") from error
        if not answer.success:
            raise NotAllowed(answer.message)
        refusal: Future[str] = Future()

        def begin() -> None:
            if refusal.set_running_or_notify_cancel():
                refusal.set_result(self._bridge.begin_homing())

        self._jobs.append(begin)
        try:
            words = refusal.result(ANSWER_TIME)
        except TimeoutError as error:
            if refusal.cancel():
                raise NotAllowed(f"the bridge did not begin within {ANSWER_TIME:g} s") from error
            words = refusal.result(ANSWER_TIME)  # it begins at this moment
        if words:
            raise NotAllowed(words)

    def _publish_state(self, now: float) -> None:
        bridge, measured = self._bridge, self._bridge.measured
        before, fault = self._last_fault.last, bridge.fault(now)
        if self._last_fault.is_due(fault, now):
            if fault and fault != before:
                rospy.logwarn("fault: %s", robot_fault(fault).words)
            self._fault.publish(String(fault))
        if measured is None or measured is self._published:
            return
        self._published = measured
        rest = measured.sent_to
        if rest is not None and self._last_rest.is_due(rest, now):
            self._rest.publish(self._joint_state(measured.stamp, rest, STILL, STILL))
        if self._grip.is_due(bridge.is_gripped, now):
            self._gripped.publish(Bool(bridge.is_gripped))
        self._publish_tension(now)  # first: the controller takes it together with the joints
        self._joints.publish(
            self._joint_state(measured.stamp, measured.position, measured.velocity, measured.effort)
        )

    def _joint_state(self, stamp: float, *rows: Vector) -> JointState:
        """Position, velocity and effort, each of shape (10,), at a moment [s]."""
        position, velocity, effort = (row.tolist() for row in rows)
        message = JointState(name=list(JOINTS), position=position, velocity=velocity, effort=effort)
        message.header.stamp, message.header.frame_id = self._clock.stamp(stamp), BASE
        return message

    def _publish_tension(self, now: float) -> None:
        """Each force once: of one told again, the controller could not judge the age."""
        force = self._bridge.force(now)
        if force is None or force is self._told_force:
            return
        self._told_force = force
        message = WrenchStamped()
        message.header.stamp, message.header.frame_id = self._clock.stamp(now), BASE
        f = message.wrench.force
        f.x, f.y, f.z = force.tolist()
        self._tension.publish(message)

    def _diagnose(self) -> None:
        health, fault = self._bridge.take_health(), self._last_fault.last
        level = DiagnosticStatus.ERROR if fault else DiagnosticStatus.OK
        values = {
            "lead": health.lead.value,
            "tool": health.tool,
            "lag [s]": f"{health.lag:.4f}",
            "off course [rad]": f"{health.off:.5f}",
            "latest velocity [s]": f"{health.latest:.4f}",
            "latest round [s]": f"{self._latest:.4f}",
            **health.arm,
            "arm: firmware": self._facts.firmware,
        }
        self._latest = 0.0
        status = DiagnosticStatus(
            level=level,
            name="robot: kinova bridge",
            message=robot_fault(fault).words if fault else "leads the arm by velocities",
            values=[KeyValue(key, value) for key, value in values.items()],
        )
        strangers = self._known.status("robot", "kinova_bridge")
        array = DiagnosticArray(status=[status, strangers])
        array.header.stamp = rospy.Time.now()
        self._diagnostics.publish(array)


def _wait(condition: Callable[[], bool], limit: float) -> bool:
    end = time.monotonic() + limit
    while not condition():
        if time.monotonic() > end:
            return False
        time.sleep(0.02)
    return True


def main() -> None:
    """Run the bridge node."""
    limit_messages()
    publish_without_waiting()
    with starting(
        "kinova_bridge", __doc__, refusals=(ConfigError, RstError), launch="kinova.launch"
    ):
        config = load_config(KinovaConfig, launch_settings(), "bridge parameters")
        require_drivable(config)
        node = KinovaBridgeNode(config, robot_description())
    spare_the_loop()
    rospy.on_shutdown(node.close)
    node.run()

# SPDX-License-Identifier: BSD-3-Clause
"""Between the controller and the drivers of arm and tool: set-points in, velocities out.

Set-points are taken and played by the same servo as the simulated robot's, with the same refusals
and faults. Who is in charge of the arm is one of three: nobody (it rests, nothing is sent), the
course (a velocity every 25 ms), or a stop that is repeated until joints that can know of it show
rest. A stop by the controller brakes along its path by velocities. Set-points that end, `hold`,
old feedback, a guard that is silent and a tool that lost its homing slow the arm down along the
curve it was on, then stop it: the driver's own stop would take the shaft off the trocar. After a
time in which this did not run, the arm is braked as its guard brakes it. A joint that does not
follow, a fault of the arm and another hand on it stop the arm by the driver's own stop at once. All
of these but `hold` latch.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from typing import Protocol

import numpy as np

from rst_control.kinematics.configuration import planning_joints, robot_joints
from rst_control.kinova.arm_state import ArmReport, ArmWatch
from rst_control.kinova.brake_plan import BrakePlan, LastCourse
from rst_control.kinova.config import KinovaConfig, bridge_limits
from rst_control.kinova.feedback import JointFeedback
from rst_control.kinova.readiness import HELD_TO_HOME, Readiness
from rst_control.kinova.tool import Grip, Tool
from rst_control.kinova.velocity_follower import Follower
from rst_control.kinova.velocity_ramp import next_due
from rst_control.robot.setpoint_servo import Servo, ServoState, warm_up
from rst_control.tension.gravity_check import RestTorques
from rst_control.types import ARM_COUNT, Measurement, Setpoint, Vector


class Hardware(Protocol):
    """What the drivers of arm and tool take."""

    def send_speeds(self, speeds: Vector) -> None:
        """Turn the arm's joints at these speeds [rad/s] until others come. Shape (7,)."""
        ...

    def send_tool(self, joints: Vector) -> None:
        """Send pitch and jaws to these angles [rad], in the tool's own signs. Shape (3,)."""
        ...

    def stop(self) -> None:
        """Stop the arm, whatever it does."""
        ...

    def clear_faults(self) -> None:
        """Ask the arm to clear its faults."""
        ...


class Lead(Enum):
    """Who is in charge of the arm."""

    NOBODY = "nobody"  # it rests; nothing is sent
    COURSE = "course"  # velocities along the course
    STOP = "stop"  # a stop was sent; repeated until the arm rests


@dataclass(frozen=True)
class BridgeHealth:
    """Figures of the bridge for diagnostics."""

    lead: Lead
    tool: str  # state of the tool, in words
    lag: float  # [s] as seen
    off: float  # [rad] of the joint furthest off its course
    latest: float  # [s] by which a velocity came late, at most
    arm: Mapping[str, str]  # what the arm says of itself, in words


class Bridge:
    """Owns the servo, the arm's follower and the tool; one thread calls it.

    Args:
        config: Limits and settings.
        hardware: Takes what is sent.
        torques: Compared with gravity's before the first motion; None: nothing is compared.
    """

    def __init__(
        self, config: KinovaConfig, hardware: Hardware, torques: RestTorques | None = None
    ) -> None:
        self._config, self._hardware = config.bridge, hardware
        self._limits = bridge_limits(config)
        warm_up(self._config.servo, self._limits)
        self._follower = Follower(self._config.arm, self._limits.speed[:ARM_COUNT])
        self.tool = Tool(self._config.tool, self._config.grip)
        self.watch = ArmWatch(self._config.arm, self._limits.speed[:ARM_COUNT])
        self._ready = Readiness(self._config, self.tool, self.watch, torques)
        self._grip = Grip(self._config.grip)
        self._has_contact = False
        self._servo: Servo | None = None  # None: the joints are not known yet
        self._lead = Lead.NOBODY
        self._force: tuple[Vector, float] | None = None  # [N], and when it came [s]
        self._arm_due = self._tool_due = self._stop_due = -np.inf
        self._goals: tuple[Vector, Vector, float] | None = None  # last two, and when [s]
        self.last_course: LastCourse | None = None  # of the newest velocity, while the arm is led
        self._plan: BrakePlan | None = None  # braking that goes before the driver's stop
        self._tool_sent: Vector | None = None  # [rad] pitch and jaws, as last sent. Shape (3,)
        self._latest = 0.0
        self._stepped = self._first_stop = np.inf  # [s] of the last step; of the stop under way
        self.measured: Measurement | None = None  # for the controller; new with each arm feedback

    # What comes from the hardware.

    def on_arm(self, feedback: JointFeedback) -> None:
        """Take in joints of the arm."""
        if self._ready.is_repeated(feedback):
            return
        self._ready.arm, tool = feedback, self.tool.joints
        position = np.concatenate([feedback.position, tool.position])
        if self._servo is None:
            self._servo = Servo(self._config.servo, self._limits, position)
        self._follower.update(feedback)
        if self._ready.torques is not None and not self.is_gripped:
            self._ready.torques.update(position, feedback.velocity, feedback.effort)
        if self._lead is Lead.NOBODY:
            self._servo.stand_at(self._stand(position))
        self.measured = Measurement(
            position=position,
            velocity=np.concatenate([feedback.velocity, tool.velocity]),
            effort=np.concatenate([feedback.effort, tool.effort]),
            stamp=feedback.stamp,
            force=np.zeros(3) if (force := self.force(feedback.stamp)) is None else force,
            gripped=self.is_gripped,
            fault=self.fault(feedback.stamp),
            sent_to=self._held(),
        )

    def on_arm_report(self, report: ArmReport) -> None:
        """Take in what the arm says of itself; a fault and another hand latch, at rest too."""
        is_moved = self.last_course is not None and bool(self.last_course.sent.any())
        cause = self.watch.update(report, self._lead is not Lead.NOBODY, is_moved)
        if cause is not None and self._servo is not None:
            self._servo.fail(cause.coded, report.stamp)
            if self._lead is Lead.COURSE:
                self._stop(report.stamp)

    def on_tool(self, feedback: JointFeedback) -> None:
        """Take in joints of the tool."""
        self.tool.take(feedback)
        measured = float(feedback.position[1:].sum())
        commanded = measured if self._tool_sent is None else float(self._tool_sent[1:].sum())
        self._grip.update(commanded, measured, feedback.stamp)

    def on_force(self, force: Vector, now: float) -> None:
        """Take in the force of the tissue on the jaws, base frame, [N]. Shape (3,)."""
        self._force = force, now

    def on_contact(self, has_contact: bool) -> None:
        """Take in what a sensor between the jaws says."""
        self._has_contact = has_contact

    def on_guard(self, now: float) -> None:
        """Note a beat of the stop guard."""
        self._ready.guard = now

    # What comes from the controller.

    def servo_jp(self, setpoint: Setpoint, now: float) -> None:
        """Take one set-point of a stream; without effect before everything is ready."""
        servo = self._servo
        if servo is None or self._lead is Lead.STOP or self._ready.objection(now):
            return
        servo.accept(setpoint, now)
        if servo.state is ServoState.FOLLOWING and self._lead is Lead.NOBODY and self._ready.arm:
            self._follower.start(self._ready.arm.position, now)
            place, _ = servo.course(now)
            self._goals, self._lead = (place, place, now), Lead.COURSE
            self._arm_due = self._tool_due = self._stepped = now  # at rest it may be late

    def hold(self, now: float) -> None:
        """Slow down along the present course, then stop."""
        if self._servo is not None:
            self._servo.hold(now)

    def clear_fault(self, now: float) -> None:
        """Take set-points again, and let the arm clear its own faults; at rest only."""
        servo = self._servo
        if servo is None or self._lead is not Lead.NOBODY:
            return
        is_faulted = bool(servo.fault) or self.watch.has_fault  # one that lasts latches only once
        if is_faulted and servo.clear_fault():
            self._hardware.clear_faults()

    def fail(self, reason: str, now: float) -> None:
        """Latch a fault, and brake an arm that is led along its course."""
        if self._servo is not None:
            self._servo.fail(reason, now)
        if self._lead is not Lead.COURSE:
            self._stop(now)

    def begin_homing(self) -> str:
        """Take the tool out of service, to be homed; why that cannot be; empty: it was done."""
        is_led = self._lead is Lead.COURSE
        is_standing = is_led and self._ready.is_led_at_rest(self.last_course, self._stepped)
        if self._lead is not Lead.NOBODY and not is_standing:
            return f"the arm is not at rest ({self._lead.value}): wait, then ask for homing again"
        if self.is_gripped:
            return "the jaws hold tissue: release it first"
        if is_led and self._servo is not None:
            self._servo.fail(HELD_TO_HOME, self._stepped)  # the next steps stop the arm
        self.tool.is_homed, self._tool_sent = False, None
        return ""

    # What the controller receives.

    def fault(self, now: float) -> str:
        """Why nothing moves, or would; empty: all is well."""
        latched = self._servo.fault if self._servo is not None else ""
        return latched or self._ready.objection(now)

    def force(self, now: float) -> Vector | None:
        """Force of the tissue [N], base frame; None: none is measured."""
        config = self._config.tension
        if config.source == "none" or self._force is None:
            return None
        force, came = self._force
        return force if now - came <= config.age else None

    @property
    def is_gripped(self) -> bool:
        """Tissue lies between the closed jaws."""
        is_by_jaws = self._config.grip.source == "jaws"
        return self._grip.is_gripped if is_by_jaws else self._has_contact

    @property
    def lead(self) -> Lead:
        """Who is in charge of the arm."""
        return self._lead

    def take_health(self) -> BridgeHealth:
        """Figures for diagnostics, since they were last taken."""
        state = "unknown" if self.tool.state is None else self.tool.state.name
        words = f"{state}, {'homed' if self.tool.is_homed else 'not homed'}"
        latest, self._latest = self._latest, 0.0
        arm, follower = self.watch.words, self._follower
        return BridgeHealth(self._lead, words, follower.lag, follower.off, latest, arm)

    # The loop.

    def step(self, now: float) -> None:
        """Do what is due."""
        servo, idle = self._servo, now - self._stepped
        self._stepped = now
        if servo is None:
            return
        if self._lead is Lead.COURSE:
            self._supervise(servo, idle, now)
        else:
            servo.course(now)  # lets its own braking end
        if self._lead is Lead.STOP:
            self._repeat_stop(servo, now)

    def _supervise(self, servo: Servo, idle: float, now: float) -> None:
        """Lead the arm on, brake it along its course, or stop it, as what is wrong demands."""
        if overslept := self._overslept(idle):
            servo.fail(overslept, now)
            self._plan = self.brake_plan(self._config.guard.silence)
            if self._plan is not None and self._ready.hears_guard(now - idle):
                self._plan.pass_over(now)  # the guard has sent them
            self._stop(now)
        elif self._follower.objection:
            servo.fail(self._follower.objection, now)
            self._stop(now)
        else:
            if not servo.fault and (wrong := self._ready.objection(now)):
                servo.fail(wrong, now)
            self._lead_on(servo, now)

    def brake_plan(self, delay: float) -> BrakePlan | None:
        """How to brake the arm, from a delay [s] after the newest velocity; None: it rests."""
        last = self.last_course
        return None if last is None else BrakePlan(self._config, last, delay)

    def _overslept(self, idle: float) -> str:
        """Why a course may not go on: for so long nobody led the arm, and its guard may brake."""
        allowed = self._config.guard.longest_gap
        if idle <= allowed:
            return ""
        return f"the bridge did not run for {idle:.2f} s in motion, allowed {allowed:.2f} s"

    def _stand(self, position: Vector) -> Vector:
        """Where set-points begin [rad], shape (10,): the tool where its node holds it.

        That is where it was sent last, unless something holds wrist or jaws elsewhere. Taken where
        it is measured, it would move on by its own error with each fault.
        """
        if self._tool_sent is None:
            return position
        (q, opening), allowed = planning_joints(position), self._config.tool.following_error
        arm = position[:ARM_COUNT]
        q_sent, opening_sent = planning_joints(np.concatenate([arm, self._tool_sent]))
        if np.abs(q - q_sent).max() <= allowed:
            q = q_sent
        if self.is_gripped or abs(opening - opening_sent) <= allowed:
            opening = opening_sent
        return robot_joints(q, opening)

    def _held(self) -> Vector | None:
        """Where the joints are held [rad], (10,); None: led, or jaws sent nobody knows where to."""
        is_known = self._tool_sent is not None or not self.is_gripped
        if self._servo is None or self._lead is not Lead.NOBODY or not is_known:
            return None
        return self._servo.rest

    def _lead_on(self, servo: Servo, now: float) -> None:
        if now >= self._arm_due:
            self._latest = max(self._latest, now - self._arm_due)
            self._arm_due = next_due(self._arm_due, now, self._config.arm.period)
            goal, speed = servo.course(now)
            if servo.state is ServoState.HOLDING:  # braked to a stand by itself
                self._hardware.send_speeds(np.zeros(ARM_COUNT))  # it stands, even if stops are lost
                self._stop(now)
                self._stop_due = now + self._config.arm.period  # so that the zeros are read first
                return
            last = self._goals[1] if self._goals is not None else goal
            self._goals = last, goal, now
            self._hardware.send_speeds(self._follower.step(goal[:ARM_COUNT], now))
            bend = servo.bend(now)[:ARM_COUNT]
            self.last_course = self._follower.last_course(speed[:ARM_COUNT], bend)
        if now >= self._tool_due and not (servo.fault and self.tool.objection(now)):
            self._tool_due = max(self._tool_due + self._config.tool.period, now)
            self._lead_tool(now)

    def _lead_tool(self, now: float) -> None:
        """Send the tool along the same straight line as the arm, at the same time."""
        if self._goals is None:
            return
        last, goal, since = self._goals
        share = min(1.0, (now - since) / self._config.arm.period)
        place = (last + share * (goal - last))[ARM_COUNT:]
        self._tool_sent = place
        self._hardware.send_tool(self.tool.command(place))
        if wrong := self.tool.following(place, now):
            self.fail(wrong, now)

    def _stop(self, now: float) -> None:
        self._lead, self._stop_due, self.last_course = Lead.STOP, now, None
        self._follower.leave()

    def _repeat_stop(self, servo: Servo, now: float) -> None:
        plan = self._plan
        if plan is not None and not plan.is_over:
            if (speeds := plan.step(now)) is not None:
                self._hardware.send_speeds(speeds)
            return
        self._plan = None
        if now >= self._stop_due:
            self._stop_due = now + self._config.arm.period
            self._hardware.stop()
            self._first_stop = min(self._first_stop, now)
        if servo.state is ServoState.HOLDING and self._ready.shows_stop(self._first_stop, now):
            self._lead, self._goals, self._first_stop = Lead.NOBODY, None, np.inf

# SPDX-License-Identifier: BSD-3-Clause
"""An arm that turns at the speeds it was last sent, late and as fast as it can change them, a tool
that is where it was sent, and set-points for both, on a clock that tests move on."""

from __future__ import annotations

from collections import deque
from dataclasses import replace

import numpy as np

from rst_control.kinematics.configuration import planning_joints, robot_joints
from rst_control.kinova.arm_state import ArmReport, ArmState, SoftLimits
from rst_control.kinova.bridge import Bridge
from rst_control.kinova.feedback import JointFeedback
from rst_control.kinova.tool import ToolState
from rst_control.trajectory.motion_profile import MotionProfile
from rst_control.types import PathState, Setpoint

STEP = 0.001  # [s]
ACCELERATION = np.array([1.0, 1.0, 1.0, 1.0, 10.0, 10.0, 10.0])  # [rad/s^2] of the driver
FEEDBACK = 0.025  # [s]
OPENING = 0.6  # [rad] of the jaws on the way


class FakeHardware:
    """Takes what the bridge sends; `advance` moves time on and reports what is measured."""

    def __init__(self, joints, delay=0.020, now=100.0):
        self.now = self.start = now
        self.arm, self.speed = np.array(joints[:7]), np.zeros(7)
        self.tool_joints = np.array(joints[7:])
        self.delay, self.offset = delay, np.zeros(7)
        self.blocked: set[int] = set()
        self.tool_error = np.zeros(3)  # [rad] of pitch and jaws, measured less sent
        self.tissue = 0.0  # [rad] of opening that tissue between the jaws leaves
        self.under_way = deque()
        self.wanted = np.zeros(7)
        self.speeds, self.tools, self.stops, self.clears = [], [], [], 0
        self.lost_stops = 0  # of the next ones, that never reach the arm
        self.reports_arm = self.reports_tool = self.guards = self.reports_state = True
        self.report = ArmReport(ArmState.SERVOING_READY, 1, now)
        self.bridge = None
        self.steps = 0
        self.each = lambda: None

    def send_speeds(self, speeds):
        self.speeds.append((self.now, speeds.copy()))
        self.under_way.append((self.now + self.delay, speeds.copy()))

    def send_tool(self, joints):
        self.tools.append((self.now, joints.copy()))
        self.tool_joints = joints.copy()
        missing = max(0.0, self.tissue - joints[1] - joints[2])
        self.tool_joints[1:] += 0.5 * missing

    def stop(self):
        self.stops.append(self.now)
        if len(self.stops) <= self.lost_stops:
            return
        self.under_way.append((self.now + self.delay, np.zeros(7)))

    def clear_faults(self):
        self.clears += 1

    def ready(self, config):
        """A bridge to this hardware, homed and guarded."""
        self.bridge = Bridge(config, self)
        self.bridge.tool.update_state(ToolState.POSITION_CONTROL.value)
        self.bridge.tool.is_homed = True
        self.bridge.watch.limits = SoftLimits(np.full(7, 0.87), ACCELERATION)
        self.report_all()
        return self.bridge

    @property
    def joints(self):
        return np.concatenate([self.arm, self.tool_joints])

    def report_all(self):
        if self.reports_tool:
            seen = self.tool_joints + self.tool_error
            self.bridge.on_tool(JointFeedback(seen, np.zeros(3), np.zeros(3), self.now))
        if self.guards:
            self.bridge.on_guard(self.now)
        if self.reports_state:
            self.bridge.on_arm_report(replace(self.report, stamp=self.now))
        if self.reports_arm:
            seen = self.arm + self.offset
            self.bridge.on_arm(JointFeedback(seen, self.speed.copy(), np.zeros(7), self.now))

    def advance(self, seconds, setpoint=None):
        """Move time on.

        Args:
            seconds: By how much.
            setpoint: Position and velocity (10,) at a time [s], sent at 500 Hz; None: none.
        """
        for _ in range(round(seconds / STEP)):
            self.steps += 1
            self.now = self.start + self.steps * STEP
            self._turn()
            if setpoint is not None and self.steps % 2 == 0:
                self.bridge.servo_jp(Setpoint(*setpoint(self.now), self.now), self.now)
            if self.steps % 25 == 0:
                self.report_all()
            if self.steps % 5 == 0:
                self.bridge.step(self.now)
            self.each()

    def _turn(self):
        while self.under_way and self.under_way[0][0] <= self.now:
            self.wanted = self.under_way.popleft()[1]
        change = np.clip(self.wanted - self.speed, -ACCELERATION * STEP, ACCELERATION * STEP)
        last = self.speed
        self.speed = self.speed + change
        for joint in self.blocked:
            self.speed[joint] = 0.0
        self.arm = self.arm + 0.5 * STEP * (last + self.speed)


class Way:
    """Set-points along the way to the grasp, up to 20 mm/s."""

    def __init__(self, planner, home, begins):
        self.paths = planner.reach(home)
        self.path, self.begins = self.paths[0], begins
        self.profile = MotionProfile(PathState(0.0), planner.pace(self.path, 0.020).moving)
        self.profile.go_to(self.path.length)
        self.last = begins

    def __call__(self, now):
        if now > self.begins:
            self.profile.step(now - max(self.last, self.begins))
        self.last = now
        point = self.path.evaluate(self.profile.state.s)
        speed = point.dq * self.profile.state.speed
        return robot_joints(point.q, OPENING), robot_joints(speed, 0.0)


def standing(hardware):
    """Set-points that hold the robot where it is now."""
    stand = hardware.joints
    return lambda now: (stand, np.zeros(10))


def closing(hardware):
    """Set-points that close the jaws where the arm stands."""
    q, _ = planning_joints(hardware.joints)

    def close(now):
        opening = max(0.0, 0.6 - (now - hardware.start))
        return robot_joints(q, opening), robot_joints(np.zeros(9), -1.0 if opening else 0.0)

    return close

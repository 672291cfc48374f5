# SPDX-License-Identifier: BSD-3-Clause
"""What the tests of the stand-in drivers share: a clock, an arm and goals that remember."""

from dataclasses import replace

import numpy as np

from rst_control.config import load_simulation_config
from rst_control.kinova.stand_in import Goal, GoalState, Point, load_stand_in_config
from rst_control.kinova.stand_in.arm import SimulatedArm
from rst_control.kinova.stand_in.driver import KinovaDriver
from rst_control.kinova.stand_in.simulated_robot import arm_limits

CONFIG = load_stand_in_config()
LIMITS = load_simulation_config().limits
STEP = 0.002  # [s] as the simulator node does
START = np.array([0.1, -0.3, 0.2, 1.4, 0.1, 1.4, -1.6])


class FakeGoal:
    """A goal that remembers what it was answered."""

    def __init__(self, *points, names=None, time_tolerance=0.0):
        self.goal = Goal(
            tuple(CONFIG.driver.joints if names is None else names),
            tuple(Point(tuple(q), t) for q, t in points),
            time_tolerance,
        )
        self.state = GoalState.OTHER
        self.said = []

    def reject(self):
        self.said.append("rejected")

    def accept(self):
        self.said.append("accepted")
        self.state = GoalState.ACTIVE

    def succeed(self, code):
        self._end(("succeeded", code))

    def abort(self, code, words):
        self._end(("aborted", code))

    def cancel(self):
        self._end("canceled")

    def ask_cancel(self):
        """As actionlib does when a client cancels an active goal."""
        self.state = GoalState.PREEMPTING

    def _end(self, how):
        if self.state is not GoalState.OTHER:  # actionlib lets a goal end once
            self.said.append(how)
            self.state = GoalState.OTHER


class Rig:
    """Driver and arm in simulated time; `seen` holds (time, position, velocity) of each step."""

    def __init__(self, **changes):
        config = replace(CONFIG.driver, **changes)
        self.limits = arm_limits(replace(CONFIG, driver=config), LIMITS)
        self.driver = KinovaDriver(config, SimulatedArm(config, self.limits, START))
        self.now, self.seen = 0.0, []

    @property
    def arm(self):
        return self.driver.arm

    def run(self, seconds, until=lambda: False):
        """Let time pass."""
        end = self.now + seconds
        while self.now < end - 1e-9 and not until():
            self.now += STEP
            self.driver.step(self.now)
            self.seen.append((self.now, self.arm.position.copy(), self.arm.velocity.copy()))

    def first_motion(self, least=1e-6):
        """Time at which a joint was first away from the start [s]; None: never."""
        return next((t for t, q, _ in self.seen if np.abs(q - START).max() > least), None)

    def at(self, time):
        """Position at a time [s]."""
        return min(self.seen, key=lambda entry: abs(entry[0] - time))[1]


def move(joint, angle):
    """The start with one joint turned by an angle [rad]."""
    q = START.copy()
    q[joint] += angle
    return q

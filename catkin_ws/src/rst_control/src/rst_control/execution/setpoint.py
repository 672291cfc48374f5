# SPDX-License-Identifier: BSD-3-Clause
"""Where the joints are sent, and what is remembered of where they stand."""

from __future__ import annotations

import numpy as np

from rst_control.commands.request import Plan
from rst_control.config import EMPTY
from rst_control.execution.motion import Motion, MotionMaker, PathPosition
from rst_control.kinematics.configuration import planning_joints, robot_joints
from rst_control.planning.plan import Grasp
from rst_control.types import JOINT_COUNT, NOT_CONNECTED, Measurement, Rejected, Vector

STILL = np.zeros(JOINT_COUNT)
CLOSED = 0.0  # [rad] opening that jaws which hold tissue are sent to, as far as is known


class SetpointState:
    """Owns motion, set-point and grasp; counts the changes that verification must know of."""

    def __init__(self, motions: MotionMaker) -> None:
        self._motions = motions
        self._place: PathPosition | None = None
        self._grasp: Grasp | None = None
        self._sent_to = CLOSED  # [rad] opening of the last set-point before it was forgotten
        self.motion: Motion | None = None
        self.held: Vector | None = None  # (10,), last set-point; None: unknown where the joints are
        self.changes = 0

    @property
    def grasp(self) -> Grasp | None:
        """What is remembered of the grasp; from the plan's start on, before anything is held."""
        return self._grasp

    @property
    def place(self) -> PathPosition | None:
        """Where the tip is, or last was, if on a path."""
        return self.motion.place if self.motion else self._place

    @property
    def pulled(self) -> float | None:
        """Place on the pull's path while tissue is pulled harder [m]; None: it is not."""
        motion, grasp = self.motion, self._grasp
        if motion is None or grasp is None or not (motion.needs_grip and motion.raises_tension):
            return None
        place = motion.place
        return place.state.s if place and place.path is grasp.pull else None

    def start(self, plan: Plan, now: float) -> Rejected | None:
        """Set off with a plan, or let it take over from the pull under way."""
        if self.held is None:
            return Rejected.by(NOT_CONNECTED)
        made = self._motions.make(plan, self.held, self.motion, self._place, now)
        if isinstance(made, Rejected):
            return made
        self.motion, self._grasp = made, plan.grasp or self._grasp
        self.changes += 1
        return None

    def advance(self, periods: int, measured: Measurement | None, now: float) -> Vector:
        """Move the set-point on; returns the velocities that belong to it [rad/s]. Shape (10,)."""
        if self.motion is None or measured is None:
            return STILL
        self.held, velocity = self.motion.advance(periods, measured, now)
        return velocity

    def finish(self) -> None:
        """Note where the motion that has come to rest left the robot."""
        if self.motion is not None:
            self._place = self.motion.place
            self._grasp = self.motion.grasp_after(self._grasp)
            self.motion = None
            self.changes += 1

    def lose(self) -> None:
        """Forget the set-point: where the joints are is no longer known."""
        if self.held is not None or self.motion is not None:
            self._remember_jaws()
            self.motion, self.held, self._place = None, None, None
            self.changes += 1

    def synchronise(self, measured: Measurement, sent_to: Vector | None = None) -> None:
        """Take over where the robot's side holds the joints; where that is not known, the measured.

        Tissue may keep jaws open that are sent to close: sent to where it does, they would hold it
        no longer. They stay where they were sent last, and are never sent further open than they
        are: whatever is said of tissue, jaws that hold none do not move by it. Joints that bend
        under their load would yield to it a little further with each set-point that was measured.

        Args:
            measured: The joints.
            sent_to: What the robot's side says of where it holds them [rad], (10,); None: nothing.
        """
        if sent_to is not None:
            self.held, self._place = sent_to, None
            self.changes += 1
            return
        self._remember_jaws()
        held = measured.position
        q, opening = planning_joints(held)
        if measured.gripped and self._sent_to < opening <= EMPTY:
            held = robot_joints(q, self._sent_to)
        self.held, self._place = held, None
        self.changes += 1

    def _remember_jaws(self) -> None:
        if self.held is not None:
            self._sent_to = planning_joints(self.held)[1]

    def drop_grasp(self) -> None:
        """Note that the jaws hold nothing any more."""
        if self._grasp is not None:
            self._grasp = None
            self.changes += 1

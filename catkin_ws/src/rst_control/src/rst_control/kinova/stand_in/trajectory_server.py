# SPDX-License-Identifier: BSD-3-Clause
"""The driver's FollowJointTrajectory server, faults included.

After ros_kortex's JointTrajectoryActionServer: it follows the arm's notices through a few states,
and some orders of events leave it in one that nobody answers for. A client must not rely on the
answer.
"""

from __future__ import annotations

import logging
from enum import Enum

from rst_control.kinova.stand_in.arm import ArmEvent, ArmRefused, Notice, SimulatedArm
from rst_control.kinova.stand_in.callback_thread import Work
from rst_control.kinova.stand_in.config import DriverConfig
from rst_control.kinova.stand_in.goals import (
    PATH_TOLERANCE_VIOLATED,
    SUCCESSFUL,
    GoalHandle,
    GoalState,
)
from rst_control.kinova.stand_in.waypoints import make_waypoints

log = logging.getLogger("rosout.rst_control.kinova_stand_in")


class ServerState(Enum):
    """Where the server believes the arm to be."""

    IDLE = "idle"
    PREPROCESSING_PENDING = "preprocessing pending"
    PREPROCESSING = "preprocessing"
    EXECUTION_PENDING = "execution pending"
    EXECUTION = "execution"


RUNS = (ServerState.EXECUTION, ServerState.EXECUTION_PENDING)
PREPROCESSES = (ServerState.PREPROCESSING_PENDING, ServerState.PREPROCESSING)


class TrajectoryServer:
    """Answers goals; `now` has to be kept up to date by the caller.

    Args:
        config: Names, waits and tolerances.
        arm: Behind it.
    """

    def __init__(self, config: DriverConfig, arm: SimulatedArm) -> None:
        self._config, self._arm = config, arm
        self._goal: GoalHandle | None = None
        self._started = 0.0  # [s] of the notice that the arm began to move
        self.state, self.now = ServerState.IDLE, 0.0

    def take(self, goal: GoalHandle) -> Work:
        """Handle a new goal; nothing else is handled meanwhile."""
        if (why := self._objection(goal)) is not None:
            log.error("goal rejected: %s", why)
            goal.reject()
            return
        if self.state is not ServerState.IDLE:
            log.warning("there is an active goal already; the arm is asked to stop")
            yield from self._stop()
        self._goal = goal  # the old one is forgotten: nobody answers it any more
        goal.accept()
        config = self._config
        waypoints = make_waypoints(goal.goal.points, config.first_duration, config.min_duration)
        yield config.calls.validate
        if found := self._arm.validate(waypoints):
            log.error("the arm does not run this trajectory: %s", "; ".join(found))
            goal.abort(SUCCESSFUL, "")  # the driver gives neither code nor words
            return
        yield config.calls.clear_faults
        self._arm.clear_faults()
        yield config.fault_wait
        yield config.calls.execute
        try:
            self._arm.execute(waypoints)
        except ArmRefused as error:
            log.error("the arm refused the trajectory: %s", error)
            goal.abort(SUCCESSFUL, "")
            return
        self.state = ServerState.PREPROCESSING_PENDING

    def take_cancel(self) -> Work:
        """Handle a cancel: without effect unless the arm is known to move."""
        if self.state is ServerState.EXECUTION:
            yield from self._stop()

    def hear(self, notice: Notice) -> None:
        """Follow a notice of the arm."""
        reactions = {
            ArmEvent.PREPROCESS_START: self._on_preprocess_start,
            ArmEvent.PREPROCESS_END: self._on_preprocess_end,
            ArmEvent.START: self._on_start,
            ArmEvent.END: self._on_end,
        }
        if notice.event is ArmEvent.ABORT:
            self._on_abort(notice.details)
        elif self._goal is not None:
            reactions[notice.event](self._goal)

    def _objection(self, goal: GoalHandle) -> str | None:
        names, wanted = goal.goal.joint_names, self._config.joints
        if len(names) != len(wanted):
            return f"it names {len(names)} joints, allowed: {len(wanted)}"
        if names != wanted:
            return f"it names {', '.join(names)}, allowed: {', '.join(wanted)}, in this order"
        return None

    def _stop(self) -> Work:
        self._arm.stop()
        yield self._config.calls.stop

    def _on_preprocess_start(self, _: GoalHandle) -> None:
        if self.state is ServerState.PREPROCESSING_PENDING:
            self.state = ServerState.PREPROCESSING

    def _on_preprocess_end(self, _: GoalHandle) -> None:
        if self.state in PREPROCESSES:
            self.state = ServerState.EXECUTION_PENDING

    def _on_start(self, goal: GoalHandle) -> None:
        is_expected = self.state in (ServerState.EXECUTION_PENDING, ServerState.PREPROCESSING)
        if is_expected and goal.state is GoalState.ACTIVE:
            self.state, self._started = ServerState.EXECUTION, self.now
        elif self.state is ServerState.EXECUTION_PENDING and goal.state is GoalState.PREEMPTING:
            log.info("the trajectory started but was cancelled: the arm is asked to stop")
            self._arm.stop()

    def _on_end(self, goal: GoalHandle) -> None:
        if self.state is not ServerState.EXECUTION:
            return
        if (why := self._missed_time(goal)) is not None:  # where the joints are is never checked
            log.error(why)
            words = "the arm did not take the time that was asked for"
            goal.abort(PATH_TOLERANCE_VIOLATED, words)
        else:
            goal.succeed(SUCCESSFUL)
        self.state = ServerState.IDLE

    def _on_abort(self, details: str) -> None:
        if self._goal is None or self.state not in RUNS:
            return
        if self._goal.state is GoalState.ACTIVE:
            words = "the arm aborted the trajectory"
            self._goal.abort(PATH_TOLERANCE_VIOLATED, f"{words}: {details}")
            self.state = ServerState.IDLE
        elif self._goal.state is GoalState.PREEMPTING:
            self._goal.cancel()
            self.state = ServerState.IDLE

    def _missed_time(self, goal: GoalHandle) -> str | None:
        took = self.now - self._started
        asked = goal.goal.points[-1].time + self._config.first_duration
        allowed = goal.goal.time_tolerance or self._config.goal_time_tolerance
        if abs(took - asked) <= allowed:
            return None
        return f"the goal took {took:.3f} s, allowed {asked - allowed:.3f} to {asked + allowed:.3f}"

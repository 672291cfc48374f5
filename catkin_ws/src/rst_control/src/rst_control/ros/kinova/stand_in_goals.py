# SPDX-License-Identifier: BSD-3-Clause
"""Goals of actionlib as the stand-in driver's core sees them."""

from __future__ import annotations

from actionlib import ServerGoalHandle
from actionlib_msgs.msg import GoalStatus
from control_msgs.msg import FollowJointTrajectoryGoal, FollowJointTrajectoryResult

from rst_control.kinova.stand_in import Goal, GoalState, Point

STATES = {
    GoalStatus.ACTIVE: GoalState.ACTIVE,
    GoalStatus.PREEMPTING: GoalState.PREEMPTING,
}


class RosGoal:
    """One goal of FollowJointTrajectory and its answer.

    Args:
        handle: Of actionlib.
    """

    def __init__(self, handle: ServerGoalHandle) -> None:
        self._handle = handle
        self.goal = read_goal(handle.get_goal())

    @property
    def state(self) -> GoalState:
        """Where it stands by now."""
        return STATES.get(self._handle.get_goal_status().status, GoalState.OTHER)

    def reject(self) -> None:
        """Refuse it."""
        self._handle.set_rejected()

    def accept(self) -> None:
        """Take it up."""
        self._handle.set_accepted()

    def succeed(self, code: int) -> None:
        """End it well."""
        self._handle.set_succeeded(FollowJointTrajectoryResult(error_code=code))

    def abort(self, code: int, words: str) -> None:
        """End it badly."""
        result = FollowJointTrajectoryResult(error_code=code, error_string=words)
        self._handle.set_aborted(result)

    def cancel(self) -> None:
        """End it as its client asked for."""
        self._handle.set_canceled()


def read_goal(message: FollowJointTrajectoryGoal) -> Goal:
    """What the driver uses of a goal; velocities, accelerations and tolerances are dropped."""
    trajectory = message.trajectory
    return Goal(
        joint_names=tuple(trajectory.joint_names),
        points=tuple(
            Point(tuple(point.positions), point.time_from_start.to_sec())
            for point in trajectory.points
        ),
        time_tolerance=message.goal_time_tolerance.to_sec(),
    )

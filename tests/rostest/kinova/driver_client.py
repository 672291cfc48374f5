# SPDX-License-Identifier: BSD-3-Clause
"""What the contract suite speaks to Kinova's driver and OpenRST's node with: ROS alone."""

from __future__ import annotations

import time

import actionlib
import numpy as np
import rospy
from actionlib_msgs.msg import GoalStatus
from control_msgs.msg import FollowJointTrajectoryAction, FollowJointTrajectoryGoal
from kortex_driver.msg import Base_JointSpeeds, JointSpeed
from sensor_msgs.msg import JointState
from std_msgs.msg import Empty
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from support.waiting import PATIENCE, wait_until

NAMES = [f"joint_{i}" for i in range(1, 8)]
MOVED = 5e-4  # [rad] (0.03 deg) of a joint that has moved; encoders tremble by less
STILL = 2e-4  # [rad] that a joint at rest changes by, at most
ENDS = (
    GoalStatus.SUCCEEDED,
    GoalStatus.ABORTED,
    GoalStatus.REJECTED,
    GoalStatus.PREEMPTED,
    GoalStatus.RECALLED,
)


class DriverClient:
    """One arm driver.

    Args:
        name: Its namespace.
    """

    def __init__(self, name: str) -> None:
        self.name, self.seen = name, []  # (arrival [s], JointState)
        self._subscriber = rospy.Subscriber(
            f"{name}/base_feedback/joint_state",
            JointState,
            lambda message: self.seen.append((time.monotonic(), message)),
            queue_size=50,
            tcp_nodelay=True,
        )
        self._empty = {
            topic: rospy.Publisher(f"{name}/in/{topic}", Empty, queue_size=1, tcp_nodelay=True)
            for topic in ("stop", "emergency_stop", "clear_faults")
        }
        self._speeds = rospy.Publisher(
            f"{name}/in/joint_velocity", Base_JointSpeeds, queue_size=1, tcp_nodelay=True
        )
        self.action = actionlib.ActionClient(
            f"{name}/gen3_joint_trajectory_controller/follow_joint_trajectory",
            FollowJointTrajectoryAction,
        )

    def wait_until_there(self) -> None:
        """Wait for the driver to be there, in all its parts."""
        there = self.action.wait_for_server(rospy.Duration(PATIENCE))
        assert there, f"no action server under {self.name}"
        wait_until(lambda: len(self.seen) > 5, f"no feedback under {self.name}")
        for topic, publisher in [*self._empty.items(), ("joint_velocity", self._speeds)]:
            wait_until(publisher.get_num_connections, f"nobody listens to {self.name}/in/{topic}")

    @property
    def q(self) -> np.ndarray:
        """Newest positions [rad]. Shape (7,)."""
        return np.array(self.seen[-1][1].position)

    def say(self, topic: str) -> float:
        """Publish `in/<topic>`; returns when [s]."""
        self._empty[topic].publish(Empty())
        return time.monotonic()

    def turn(self, speeds: dict[int, float]) -> None:
        """Publish joint speeds [rad/s] of joints counted from 0."""
        entries = [JointSpeed(joint, speed, 0) for joint, speed in speeds.items()]
        self._speeds.publish(Base_JointSpeeds(entries, 0))

    def send(self, points, names=NAMES):
        """Send a goal.

        Args:
            points: Positions [rad] and time [s] of each.
            names: Of the joints.

        Returns:
            Its handle, and when it was sent [s].
        """
        goal = FollowJointTrajectoryGoal(trajectory=JointTrajectory(joint_names=list(names)))
        goal.trajectory.points = [
            JointTrajectoryPoint(positions=list(q), time_from_start=rospy.Duration(t))
            for q, t in points
        ]
        handle = self.action.send_goal(goal)
        return handle, time.monotonic()

    def finish(self, handle, limit: float = PATIENCE):
        """Wait for the end of a goal; returns its status and result."""
        wait_until(lambda: handle.get_goal_status() in ENDS, "the goal never ended", limit)
        status = handle.get_goal_status()
        if (
            status != GoalStatus.REJECTED
        ):  # the result comes after the status, by a topic of its own
            wait_until(handle.get_result, "the goal has no result", limit)
        return status, handle.get_result()

    def first_motion(self, since: float, start) -> float | None:
        """Seconds after `since` at which a joint was away from `start`; None: never."""
        for arrival, message in list(self.seen):
            away = np.abs(wrapped(np.array(message.position) - start)).max()
            if arrival > since and away > MOVED:
                return arrival - since
        return None

    def rest(self, seconds: float = 0.5) -> np.ndarray:
        """Wait until the arm stands for so long; returns where [rad]."""
        time.sleep(seconds)
        wait_until(lambda: self.stands(seconds), "the arm does not come to rest")
        return self.q

    def halt(self, seconds: float = 0.5) -> np.ndarray:
        """Say "stop" until the arm stands for so long; returns where [rad].

        A speed that was sent before a "stop" can reach the driver after it: each has its own topic.
        """

        def stands() -> bool:
            self.say("stop")
            time.sleep(seconds)
            return self.stands(seconds)

        wait_until(stands, "no stop brings the arm to rest")
        return self.q

    def stands(self, seconds: float) -> bool:
        """Whether the arm has stood for so long."""
        now = time.monotonic()
        recent = [m.position for t, m in list(self.seen)[-200:] if now - t < seconds]
        return len(recent) > 3 and bool(np.ptp(np.array(recent), axis=0).max() < STILL)


def wrapped(angles: np.ndarray) -> np.ndarray:
    """Differences of angles, from -pi to pi [rad]."""
    return np.mod(angles + np.pi, 2.0 * np.pi) - np.pi

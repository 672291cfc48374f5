# SPDX-License-Identifier: BSD-3-Clause
"""How the simulation fares, on /diagnostics; and the places that do not move, on /tf_static."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import PointStamped, TransformStamped
from tf2_msgs.msg import TFMessage

from rst_control.config import SceneConfig
from rst_control.ros.simulator.pace import SimulationPace
from rst_control.simulation.exposure import exposure, exposure_words
from rst_control.simulation.pybullet_robot import PybulletRobot
from rst_control.types import BASE, robot_fault
from typed_config.ros.known_publishers import KnownPublishers

PERIOD = 1.0  # [s]
LATE_SHARE = 0.05  # of the periods, above which a warning is given


class SimulatorDiagnostics:
    """Publishes the health of the simulation.

    Args:
        robot: What is simulated.
        pace: Counts lateness.
        period: Simulated time between two calls [s].
        scene: With the bands of a triangulated sheet, and the grasp point until another is set.
        known: Makes the subscriber to the grasp point that counts.
        led_by: Nodes that are believed there.
    """

    def __init__(
        self,
        robot: PybulletRobot,
        pace: SimulationPace,
        period: float,
        scene: SceneConfig,
        known: KnownPublishers,
        led_by: Sequence[str],
    ) -> None:
        self._robot, self._pace, self._period = robot, pace, period
        self._scene = scene
        known.subscribe("rst_control/grasp_point", PointStamped, self._on_grasp, led_by)
        self.priority = "none"  # what the system granted, in words
        self._topic = rospy.Publisher("/diagnostics", DiagnosticArray, queue_size=2)
        self._wall, self._busy = time.monotonic(), time.process_time()
        self._periods, self._late = 0, 0

    def is_due(self) -> bool:
        """Whether it is time to publish."""
        return time.monotonic() - self._wall >= PERIOD

    def publish(self, strangers: DiagnosticStatus) -> None:
        """Publish what happened since the last time, and who is not believed."""
        pace, robot = self._pace, self._robot
        wall, busy = time.monotonic(), time.process_time()
        periods, late = pace.periods - self._periods, pace.late - self._late
        factor = periods * self._period / (wall - self._wall)
        load = (busy - self._busy) / (wall - self._wall)
        self._wall, self._busy = wall, busy
        self._periods, self._late = pace.periods, pace.late
        level, words = self._verdict(late / max(periods, 1))
        age = robot.now - robot.newest_setpoint
        values = {
            "real-time factor": f"{factor:.3f}",
            "late steps": f"{late} of {periods}",
            "time given up [s]": f"{pace.given_up:.3f}",
            "priority": self.priority,
            "processor load": f"{load:.2f}",
            "servo": robot.servo_state.value,
            "age of the last set-point [s]": f"{age:.4f}" if np.isfinite(age) else "none",
            "tension [N]": f"{np.linalg.norm(robot.force):.3f}",
        }
        status = DiagnosticStatus(level=level, name="robot: simulation", message=words)
        status.values = [KeyValue(key, value) for key, value in values.items()]
        message = DiagnosticArray(status=[status, self._exposure(), strangers])
        message.header.stamp = rospy.Time.now()
        self._topic.publish(message)

    def _on_grasp(self, message: PointStamped) -> None:
        """Take over the point that the controller grasps at."""
        p = message.point
        self._scene = replace(self._scene, grasp_point=(p.x, p.y, p.z))

    def _exposure(self) -> DiagnosticStatus:
        """Whether the tissue is triangulated, and by how much it is or is not."""
        held = exposure(self._robot.tissue, self._scene, self._robot.force)
        words = exposure_words(held, self._scene)
        status = DiagnosticStatus(level=DiagnosticStatus.OK, name="robot: tissue", message=words)
        if held is not None:
            values = {
                "grasp error [mm]": f"{1e3 * held.grasp_error:.3f}",
                "least angle [deg]": f"{np.degrees(held.min_angle):.1f}",
                "out of plane rms [mm]": f"{1e3 * held.out_of_plane:.3f}",
                "tension [N]": f"{held.tension:.3f}",
                "strain": f"{held.strain:.3f}",
            }
            status.values = [KeyValue(key, value) for key, value in values.items()]
        return status

    def _verdict(self, late_share: float) -> tuple[int, str]:
        if self._robot.fault:
            return DiagnosticStatus.ERROR, robot_fault(self._robot.fault).words
        if late_share > LATE_SHARE:
            return DiagnosticStatus.WARN, f"{late_share:.0%} of the steps began late"
        return DiagnosticStatus.OK, "keeping up"


def publish_places(scene: SceneConfig) -> rospy.Publisher:
    """Publish the trocar as frame `rcm` and the middle of the tissue as frame `phantom`."""
    transforms = []
    for name, place in (("rcm", scene.trocar), ("phantom", scene.tissue.centre)):
        transform = TransformStamped()
        transform.header.stamp = rospy.Time.now()
        transform.header.frame_id, transform.child_frame_id = BASE, name
        translation = transform.transform.translation
        translation.x, translation.y, translation.z = place
        transform.transform.rotation.w = 1.0
        transforms.append(transform)
    publisher = rospy.Publisher("/tf_static", TFMessage, queue_size=1, latch=True)
    publisher.publish(TFMessage(transforms))
    return publisher

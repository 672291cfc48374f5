# SPDX-License-Identifier: BSD-3-Clause
"""The stop guard as a process of its own: brakes and stops the arm when the bridge is silent.

It tells the bridge that it is there only while it hears the bridge, and while the arm's driver is
connected to it. Any other guard would let the bridge lead the arm unguarded.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Iterable
from typing import Any

import rospy
from kortex_driver.msg import Base_JointSpeeds
from std_msgs.msg import Empty

from rst_control.kinova.config import BridgeConfig
from rst_control.kinova.guard import StopGuard
from rst_control.msg import BridgeBeat
from rst_control.ros.common.priority import ask_for_priority
from rst_control.ros.kinova.beat import course_of
from rst_control.ros.kinova.hardware import speeds_message
from rst_control.ros.rospy_patches.message_limits import limit_messages
from rst_control.ros.rospy_patches.nonblocking_publish import publish_without_waiting
from typed_config import load_config
from typed_config.node_names import is_allowed
from typed_config.ros.connections import open_listeners
from typed_config.ros.known_publishers import KnownPublishers
from typed_config.ros.launch_settings import launch_settings
from typed_config.ros.starting import starting
from typed_config.ros.system_names import of_this_system

PERIOD = 0.005  # [s] between two rounds
CLOSING = 1.5  # [s] beyond the allowed silence for which it guards when it is ended
STOPPING = 0.2  # [s] more after it has braked, for the stops
ALIVE_EVERY = 4  # rounds between two beats for the bridge
SAY_AGAIN = 10.0  # [s] before a driver that does not hear is named again


def main() -> None:
    """Run the guard node."""
    limit_messages()
    publish_without_waiting()
    with starting("kinova_guard", __doc__, needs_clock=False, launch="kinova.launch"):
        settings = launch_settings()
        config = load_config(BridgeConfig, settings.get("bridge", {}), "guard parameters")
        node = GuardNode(config)
        rospy.on_shutdown(node.close)
    ask_for_priority()
    node.run()


def is_heard_by(topic: rospy.Publisher, patterns: Iterable[str]) -> bool:
    """Whether a node of an allowed name is connected; that a recorder is, says nothing."""
    return any(is_allowed(name, patterns) for name in open_listeners(topic))


class GuardNode:
    """Hears the bridge's beats; brakes and stops the arm where they fail to come."""

    def __init__(self, config: BridgeConfig) -> None:
        self._guard, self._lock = StopGuard(config), threading.Lock()
        self._silence = config.guard.silence
        newest: dict[str, Any] = {"queue_size": 1, "tcp_nodelay": True}
        arm = config.arm.namespace
        self._stop = rospy.Publisher(f"{arm}/in/stop", Empty, **newest)
        self._speeds = rospy.Publisher(f"{arm}/in/joint_velocity", Base_JointSpeeds, **newest)
        self._drivers = tuple(map(of_this_system, config.believed.arm))  # [] stands for anybody
        self._alive = rospy.Publisher("kinova_guard/alive", Empty, **newest)
        beat = "kinova_bridge/beat"
        self._known = KnownPublishers()
        self._known.subscribe(beat, BridgeBeat, self._on_beat, config.guard.bridge, **newest)

    def run(self) -> None:
        """Guard until ROS shuts down."""
        rounds, was_silent = 0, False
        while not rospy.is_shutdown():
            self._guard_once()
            now = time.monotonic()
            is_silent = self._guard.is_silent(now)
            if is_silent and not was_silent:
                rospy.logerr("the bridge is silent: the arm is braked along its course and stopped")
            was_silent = is_silent
            rounds += 1
            if rounds % ALIVE_EVERY == 0 and self._guard.hears_bridge(now):
                self._say_alive()
            self._known.publish_status()
            time.sleep(PERIOD)

    def close(self) -> None:
        """Guard a little longer: a bridge that died is what roslaunch ends all nodes for.

        A bridge that lives is heard meanwhile, and brakes the arm by itself.
        """
        end = time.monotonic() + self._silence + CLOSING
        while (now := time.monotonic()) < end:
            self._guard_once()
            if self._guard.is_braking:
                end = max(end, now + STOPPING)
            time.sleep(PERIOD)

    def _say_alive(self) -> None:
        """Tell the bridge that it has a guard, where the arm's driver hears its brake and stop."""
        topics = (self._stop, self._speeds)
        unheard = [t.resolved_name for t in topics if not is_heard_by(t, self._drivers)]
        if not unheard:
            self._alive.publish(Empty())
            return
        words = "the arm's driver does not hear this guard: %s; allowed: %s"
        allowed = ", ".join(self._drivers) or "anybody"
        rospy.logwarn_throttle(SAY_AGAIN, words, ", ".join(unheard), allowed)

    def _on_beat(self, message: BridgeBeat) -> None:
        now = time.monotonic()
        course = course_of(message, now)
        with self._lock:
            self._guard.heard(now, course)

    def _guard_once(self) -> None:
        """Brake or stop the arm, where that is due."""
        with self._lock:  # what is sent after a beat of the bridge would be in its way
            now = time.monotonic()
            braking = self._guard.speeds_due(now)
            if braking is not None:
                self._speeds.publish(speeds_message(braking))
            elif self._guard.is_stop_due(now):
                self._stop.publish(Empty())

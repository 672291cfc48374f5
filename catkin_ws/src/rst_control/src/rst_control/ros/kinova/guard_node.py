# SPDX-License-Identifier: BSD-3-Clause
"""The stop guard as a process of its own: publishes in/stop when the bridge falls silent."""

from __future__ import annotations

import sys
import time

import rospy
from std_msgs.msg import Empty

from rst_control.kinova.config import GuardConfig
from rst_control.kinova.guard import StopGuard
from rst_control.ros.common.known_publishers import KnownPublishers
from rst_control.ros.common.launch_settings import launch_settings
from rst_control.ros.common.priority import ask_for_priority
from rst_control.ros.kinova.hardware import send_at_shutdown
from rst_control.ros.rospy_patches.nonblocking_publish import publish_without_waiting
from typed_config import ConfigError, load_config
from typed_config.ros.starting import starting

PERIOD = 0.010  # [s] between two rounds
ALIVE_EVERY = 2  # rounds between two beats for the bridge


def main() -> None:
    """Run the guard node."""
    publish_without_waiting()
    with starting("kinova_guard", needs_clock=False):
        try:
            settings = launch_settings()
            guard_settings = settings.get("bridge", {}).get("guard", {})
            config = load_config(GuardConfig, guard_settings, "guard parameters")
        except ConfigError as error:
            rospy.logfatal(f"the stop guard cannot start: {error}; launch/kinova.launch starts it")
            sys.exit(2)
        guard = StopGuard(config)
        newest = {"queue_size": 1, "tcp_nodelay": True}
        stop = rospy.Publisher(f"{settings['arm_namespace']}/in/stop", Empty, **newest)
        alive = rospy.Publisher("kinova_guard/alive", Empty, **newest)
        KnownPublishers().subscribe(
            "kinova_bridge/beat",
            Empty,
            lambda _: guard.heard(time.monotonic()),
            config.bridge,
            **newest,
        )
        # A guard that ends guards no longer: the arm stops, whether the bridge is there or not.
        rospy.on_shutdown(lambda: send_at_shutdown(lambda: stop.publish(Empty())))
    ask_for_priority()
    rounds, was_silent = 0, False
    while not rospy.is_shutdown():
        now = time.monotonic()
        if guard.is_stop_due(now):
            stop.publish(Empty())
            if not was_silent:
                rospy.logerr("the bridge is silent: the arm is stopped")
        was_silent = guard.is_silent(now)
        rounds += 1
        if rounds % ALIVE_EVERY == 0:
            alive.publish(Empty())
        time.sleep(PERIOD)

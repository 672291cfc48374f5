# SPDX-License-Identifier: BSD-3-Clause
"""Trocar and grasp point as they count: on their latched topics, and kept for a restart.

What was set is kept in the node's private parameters, which a new launch clears. A controller that
is started anew within the launch, as after a crash, takes it from there.
"""

from __future__ import annotations

import json
import math
import threading
import time
from typing import Any, Final

import rosgraph
import rospy
from geometry_msgs.msg import PointStamped

from rst_control.config import SceneConfig
from rst_control.errors import RstError
from rst_control.registration.grasp_point import off_tissue
from rst_control.registration.trocar_context import (
    SCENE,
    ActiveTrocarContext,
    Origin,
    TrocarContext,
)
from rst_control.ros.common.wall_clock import RosClock
from rst_control.ros.controller.messages import base_point
from typed_config.ros.launch_settings import IN_FORCE
from typed_config.ros.xmlrpc import FAILURES, ask

KEEP_AGAIN: Final = 5.0  # [s] after which a master that did not take them is asked again
PLACES: Final = f"~{IN_FORCE}/places"
NOT_KEPT: Final = "the places that were set are not kept for a restart yet: %s"
NOT_TAKEN: Final = "places that were set before are not taken: %s; those of scene.yaml count"


class PlacesInForce:
    """Publishes `rst_control/trocar` and `rst_control/grasp_point`, and keeps them.

    Args:
        present: The active trocar and grasp point.
        clock: Translates times.
    """

    def __init__(self, present: ActiveTrocarContext, clock: RosClock) -> None:
        self._present, self._clock, self._lock = present, clock, threading.Lock()
        latched: dict[str, Any] = {"queue_size": 1, "latch": True}
        self._trocar = rospy.Publisher("rst_control/trocar", PointStamped, **latched)
        self._grasp = rospy.Publisher("rst_control/grasp_point", PointStamped, **latched)
        self._shown: dict[rospy.Publisher, Origin] = {}
        self._keep_at = math.inf  # [s] steady clock, when they are to be kept; infinite: they are
        self._restore()
        self.step()

    def step(self) -> None:
        """Publish and keep what was set since the last time; any thread may call it."""
        with self._lock:
            trocar, grasp, scene = self._in_force()
            is_new = self._show(self._trocar, scene.trocar, trocar)
            if self._show(self._grasp, scene.grasp_point, grasp) or is_new:
                self._keep_at = -math.inf
            if time.monotonic() >= self._keep_at:
                self._keep_at = self._keep()

    def _show(self, topic: rospy.Publisher, place: tuple[float, ...], origin: Origin) -> bool:
        if self._shown.get(topic) == origin:
            return False
        self._shown[topic] = origin
        topic.publish(base_point(place))
        return True

    def _in_force(self) -> tuple[Origin, Origin, SceneConfig]:
        """Who set trocar and grasp point, and both.

        The control loop replaces places first. So they are read last: a place is never older than
        who set it, and one that is newer is shown again in the next step.
        """
        trocar, grasp = self._present.trocar_origin, self._present.grasp_origin
        return trocar, grasp, self._present.current.config.scene

    def _keep(self) -> float:
        """Hand them to the master; gives when to do so again [s]: never, unless it failed."""
        trocar, grasp, scene = self._in_force()
        kept: dict[str, Any] = {}
        for name, origin, numbers in (
            ("trocar", trocar, scene.trocar),
            ("grasp", grasp, (*scene.grasp_point, *scene.pull_direction)),
        ):
            if origin.source != SCENE:
                stamp = self._clock.stamp(origin.stamp).to_sec()
                kept[name] = {"numbers": numbers, "source": origin.source, "stamp": stamp}
        key, master = rospy.resolve_name(PLACES), rosgraph.get_master_uri()
        try:
            if kept:
                ask(master, "setParam", rospy.get_name(), key, json.dumps(kept))
        except FAILURES as error:
            rospy.logwarn(NOT_KEPT, error)
            return time.monotonic() + KEEP_AGAIN
        return math.inf

    def _restore(self) -> None:
        try:
            kept = json.loads(rospy.get_param(PLACES, "{}"))
            context, origins = self._present.current, {}
            for name, entry in kept.items():
                numbers = [float(value) for value in entry["numbers"]]
                context = _with(context, name, numbers)
                stamp = self._clock.steady(float(entry["stamp"]))
                origins[name] = Origin(str(entry["source"]), stamp)
        except (ValueError, TypeError, KeyError, AttributeError, RstError) as error:
            rospy.logerr(NOT_TAKEN, error)
            return
        self._present.current = context
        self._present.trocar_origin = origins.get("trocar", self._present.trocar_origin)
        self._present.grasp_origin = origins.get("grasp", self._present.grasp_origin)
        for name, origin in origins.items():
            rospy.logwarn("the %s that %s set before this start counts", name, origin.source)


def _with(context: TrocarContext, name: str, numbers: list[float]) -> TrocarContext:
    """A context with a place that was kept.

    Raises:
        RstError: No arm reaches it.
        ValueError: It is none that was ever set.
    """
    if not all(map(math.isfinite, numbers)):
        raise ValueError(f"{name} at {numbers}, allowed: finite numbers")
    if name == "trocar":
        return context.with_trocar(numbers)
    if refusal := off_tissue(context.config.scene, numbers[:3]):
        raise ValueError(refusal.words)
    return context.with_grasp_point(numbers[:3], numbers[3:])

# SPDX-License-Identifier: BSD-3-Clause
"""What can be known of live drivers without moving anything, as a table for the person there."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np

from rst_control.kinematics.configuration import Configuration, planning_joints
from rst_control.kinematics.rcm import rcm_state
from rst_control.kinematics.robot_model import parse_robot
from rst_control.kinova.arm_state import ArmReport, SoftLimits
from rst_control.kinova.config import KinovaConfig, bridge_limits
from rst_control.kinova.feedback import JointFeedback
from rst_control.kinova.tool import ToolState
from rst_control.tension.gravity_check import RestTorques
from rst_control.types import ARM_COUNT, Vector
from typed_config.node_names import is_allowed

MIN_SHARE: Final = 0.95  # of the arm's feedback_rate
MAX_CLOCK: Final = 0.5  # [s] between the clocks of two hosts
ALIKE: Final = 20  # states without any change, which no arm with torque sensors gives
BRIDGE, GUARD = "/kinova_bridge", "/kinova_guard"  # nodes
STOPPING: Final = ("in/joint_velocity", "in/stop")  # of the arm's driver: what brakes and stops it
MOTION: Final = (
    "in/joint_velocity",
    "in/cartesian_velocity",
    "gen3_joint_trajectory_controller/follow_joint_trajectory/goal",
)  # of the arm's driver: what moves it


@dataclass(frozen=True)
class Observed:
    """What was seen and heard for a while."""

    seconds: float
    arm: Sequence[JointFeedback] = ()  # in the turn of home, by when each came
    bad_feedback: str = ""  # why the newest one that was unusable was so
    reports: Sequence[ArmReport] = ()  # of the arm's own state, by when each came
    limits: SoftLimits | None = None  # soft limits of the arm
    firmware: str = ""  # of the arm
    clock: float | None = None  # [s] of the newest stamp behind this host's clock
    tool: JointFeedback | None = None
    bad_tool: str = ""  # the same of the tool's
    tool_state: int | None = None
    guard_beats: int = 0
    is_guard_connected: bool = False  # it runs; it beats while it hears bridge and driver hears it
    forces: Sequence[Vector] = ()  # [N] of the force sensor, each of shape (3,)
    publishers: Mapping[str, Sequence[str]] | None = None  # nodes by topic, as the master says
    subscribers: Mapping[str, Sequence[str]] | None = None


@dataclass(frozen=True)
class CheckResult:
    """One row of the table."""

    name: str
    is_met: bool | None  # None: it could not be found out
    found: str
    next_step: str = ""


class LiveChecks:
    """All checks, in the order in which a person puts right what they find.

    Args:
        config: Of the bridge.
        trocar: As measured, base frame, [m]. Shape (3,).
        description: URDF text of the robot.
        tolerance: Of the shaft from the trocar [m].
        named: Makes the whole name, where the system runs in a namespace, of one without it.

    Raises:
        RobotModelError: The URDF is not this robot's.
    """

    def __init__(
        self,
        config: KinovaConfig,
        trocar: Vector,
        description: str,
        tolerance: float,
        named: Callable[[str], str] = str,
    ) -> None:
        self._named = named
        self._config, self._trocar, self._tolerance = config, trocar, tolerance
        self._description, self._model = description, parse_robot(description)
        self._arm, self._tool = config.bridge.arm, config.bridge.tool
        self._speed = bridge_limits(config).speed[:ARM_COUNT]  # [rad/s] of the plans, at most

    def __call__(self, seen: Observed) -> list[CheckResult]:
        """The table of what was observed."""
        checks: tuple[Callable[[Observed], CheckResult], ...] = (
            self._feedback,
            self._gaps,
            self._changes,
            self._state,
            self._soft_limits,
            self._firmware,
            self._clock,
            self._source,
            self._listens,
            self._others,
            self._rests,
            self._limits,
            self._turns,
            self._gravity,
            self._tool_joints,
            self._shaft,
            self._tool_state,
            self._force,
            self._guard,
        )
        return [check(seen) for check in checks]

    def _feedback(self, seen: Observed) -> CheckResult:
        name, topic = "arm reports its joints", f"{self._arm.namespace}/base_feedback/joint_state"
        if not seen.arm:
            found = seen.bad_feedback or f"nothing on {topic}"
            return CheckResult(name, False, found, "step 2: driver, ROS_MASTER_URI, ROS_IP, names")
        rate = len(seen.arm) / seen.seconds
        needed = MIN_SHARE * self._arm.feedback_rate
        found, step = f"{rate:.1f} Hz, at least {needed:.0f}", "step 2: cyclic_data_publish_rate"
        return CheckResult(name, rate >= needed, found, f"{step}; step 1: network")

    def _gaps(self, seen: Observed) -> CheckResult:
        name, allowed = "no state is late", self._arm.feedback_age
        if len(seen.arm) < 2:
            return CheckResult(name, None, "too few states")
        longest = float(np.diff([state.stamp for state in seen.arm]).max())
        found = f"longest gap {longest * 1e3:.0f} ms, allowed {allowed * 1e3:.0f} ms"
        return CheckResult(name, longest <= allowed, found, "step 1: a lost reply stops a motion")

    def _changes(self, seen: Observed) -> CheckResult:
        name = "states are new ones"
        if len(seen.arm) < ALIKE:
            return CheckResult(name, None, "too few states")
        rows = [np.concatenate([s.position, s.velocity, s.effort]) for s in seen.arm]
        changes = any(not np.array_equal(a, b) for a, b in pairwise(rows))
        found = "they differ" if changes else f"all {len(rows)} are equal to the last bit"
        return CheckResult(name, changes, found, "the driver repeats itself: start it anew")

    def _state(self, seen: Observed) -> CheckResult:
        name, topic = "arm is ready and nobody has it", f"{self._arm.namespace}/base_feedback"
        if not self._arm.reports_state:
            return CheckResult(name, None, "arm.reports_state is false: not read")
        if not seen.reports:
            return CheckResult(name, False, f"nothing on {topic}", "step 2: the driver's version")
        found = [report.objection() for report in seen.reports]
        causes = [cause.words for cause in found if cause is not None]
        words = causes[-1] if causes else f"{seen.reports[-1].state_name}, no fault"
        warned = "; ".join(seen.reports[-1].warnings)
        step = "the arm's web page names it and clears it; close that page, put joysticks away"
        words += f"; warnings: {warned}" if warned else ""
        return CheckResult(name, not causes, words, step)

    def _soft_limits(self, seen: Observed) -> CheckResult:
        name = "arm's soft limits are enough"
        if not self._arm.reports_limits:
            return CheckResult(name, None, "arm.reports_limits is false: not read")
        step = "step 2: set them on the web page, or lower arm.acceleration and the plans' limits"
        if seen.limits is None:
            return CheckResult(name, False, "the driver does not say them", step)
        objection = seen.limits.objection(self._arm, self._speed)
        return CheckResult(name, objection is None, objection.words if objection else "yes", step)

    def _firmware(self, seen: Observed) -> CheckResult:
        name = "arm's firmware is known"
        return CheckResult(name, bool(seen.firmware) or None, seen.firmware or "not said")

    def _clock(self, seen: Observed) -> CheckResult:
        name = "clocks of the hosts agree"
        if seen.clock is None:
            return CheckResult(name, None, "no stamp")
        found = f"{seen.clock:+.3f} s, allowed {MAX_CLOCK:g} s"
        return CheckResult(name, abs(seen.clock) <= MAX_CLOCK, found, "chrony on both hosts")

    def _source(self, seen: Observed) -> CheckResult:
        name = "one believed driver reports"
        nodes = self._nodes(seen.publishers, "base_feedback/joint_state")
        if nodes is None:
            return CheckResult(name, None, "the master does not answer")
        believed = self._config.bridge.believed.arm
        is_met = len(nodes) == 1 and is_allowed(nodes[0], tuple(map(self._named, believed)))
        step = "end the others; bridge.believed.arm names who is believed"
        return CheckResult(name, is_met, _words(nodes), step)

    def _listens(self, seen: Observed) -> CheckResult:
        name, silent = "driver takes velocities and stops", []
        for topic in STOPPING:
            nodes = self._nodes(seen.subscribers, topic)
            if nodes is None:
                return CheckResult(name, None, "the master does not answer")
            silent += [] if nodes else [topic]
        found = f"nobody hears {' and '.join(silent)}" if silent else "it hears both"
        return CheckResult(name, not silent, found, "step 2: the driver's log")

    def _others(self, seen: Observed) -> CheckResult:
        name, found = "nobody else moves the arm", set[str]()
        for topic in MOTION:
            nodes = self._nodes(seen.publishers, topic)
            if nodes is None:
                return CheckResult(name, None, "the master does not answer")
            found |= set(nodes) - {self._named(BRIDGE), self._named(GUARD)}
        words = _words(sorted(found)) if found else "nobody"
        return CheckResult(name, not found, words, "end it: the driver obeys anybody")

    def _rests(self, seen: Observed) -> CheckResult:
        name, allowed = "arm rests", self._arm.rest_speed
        if not seen.arm:
            return CheckResult(name, None, "no state")
        fastest = max(float(np.abs(state.velocity).max()) for state in seen.arm)
        found = f"at most {fastest:.4f} rad/s, allowed {allowed:g}"
        return CheckResult(name, fastest <= allowed, found, "end hand guiding and all motion")

    def _limits(self, seen: Observed) -> CheckResult:
        name, limits = "joints are within their limits", self._config.limits
        if not seen.arm:
            return CheckResult(name, None, "no state")
        q, margin = seen.arm[-1].position, limits.position_margin
        room = np.minimum(q - np.array(limits.arm_lower), np.array(limits.arm_upper) - q)
        joint = int(room.argmin())
        found = f"{self._arm.joints[joint]} {room[joint]:.3f} rad from its limit"
        found += f", at least {margin:g}"
        return CheckResult(name, bool(room[joint] >= margin), found, "guide it towards home")

    def _turns(self, seen: Observed) -> CheckResult:
        name = "joints are in the turn of home"
        if not seen.arm:
            return CheckResult(name, None, "no state")
        away = np.abs(seen.arm[-1].position - np.array(self._config.scene.home[:ARM_COUNT]))
        joint = int(away.argmax())
        found = f"{self._arm.joints[joint]} {away[joint]:.3f} rad from home, at most {math.pi:.3f}"
        return CheckResult(name, bool(away[joint] <= math.pi), found, "step 7: angles of home")

    def _gravity(self, seen: Observed) -> CheckResult:
        name = "torques at rest are gravity's"
        if not seen.arm:
            return CheckResult(name, None, "no state")
        config, scene = self._config, self._config.scene
        torques = RestTorques(config.torques, self._description, scene.gravity)
        for state in seen.arm:
            torques.update(self._joints(seen, state), state.velocity, state.effort)
        step = "step 2, mounting: payload, effort_sign, gravity"
        return CheckResult(name, not torques.refusal, torques.refusal or "they fit", step)

    def _shaft(self, seen: Observed) -> CheckResult:
        name = "shaft is in the trocar"
        if not seen.arm:
            return CheckResult(name, None, "no state")
        q = planning_joints(self._joints(seen, seen.arm[-1]))[0]
        error = rcm_state(Configuration(self._model, q), self._trocar).error
        found = f"{error * 1e3:.2f} mm off it, allowed {self._tolerance * 1e3:.2f} mm"
        return CheckResult(name, error <= self._tolerance, found, "steps 6 and 7; guide it back")

    def _tool_joints(self, seen: Observed) -> CheckResult:
        name, topic = "tool reports its joints", f"{self._tool.namespace}/joint_states"
        if seen.tool is None:
            found = seen.bad_tool or f"nothing on {topic}"
            return CheckResult(name, False, found, "step 4: its node, tool.joints")
        return CheckResult(name, True, ", ".join(self._tool.joints))

    def _tool_state(self, seen: Observed) -> CheckResult:
        name, wanted = "tool holds its position", ToolState.POSITION_CONTROL.value
        if seen.tool_state is None:
            return CheckResult(name, False, "OpenRST says nothing", "step 4: its node, its DAQ")
        known = [state.name for state in ToolState if state.value == seen.tool_state]
        found = known[0] if known else f"state {seen.tool_state}"
        return CheckResult(name, seen.tool_state == wanted, found, "step 4; then robot/home_tool")

    def _force(self, seen: Observed) -> CheckResult:
        name = "tension is measured"
        if self._config.bridge.tension.source == "none":
            return CheckResult(name, None, "tension.source is none: pulls go by distance")
        if not seen.forces:
            step = "step 8: the sensor's driver, or torque_tension.launch"
            return CheckResult(name, False, "nothing on robot/tension_sensor", step)
        forces = np.array(seen.forces)
        if not np.isfinite(forces).all():
            return CheckResult(name, False, "some are no numbers", "step 8: the sensor's driver")
        mean, rate = float(np.linalg.norm(forces.mean(axis=0))), len(forces) / seen.seconds
        found = f"{mean:.3f} N at {rate:.0f} Hz; with empty jaws it should be near 0"
        return CheckResult(name, True, found)

    def _guard(self, seen: Observed) -> CheckResult:
        name = "stop guard is there"
        if seen.guard_beats:
            rate = seen.guard_beats / seen.seconds
            found = f"it hears the bridge, the driver hears it: {rate:.0f} beats a second"
            return CheckResult(name, True, found)
        if not seen.is_guard_connected:
            return CheckResult(name, None, "not there; kinova.launch starts it")
        if seen.publishers is None:
            return CheckResult(name, None, "silent; the master does not answer")
        guards, senders = seen.publishers.get(self._named(f"{GUARD}/alive"), ()), seen.publishers
        astray = {g for t in STOPPING for g in guards if g not in (self._nodes(senders, t) or ())}
        if astray:
            found = f"{_words(sorted(astray))} guards another arm than {self._arm.namespace}"
            return CheckResult(name, False, found, "arm:= of kinova_guard.launch")
        if bridges := seen.publishers.get(self._named(f"{BRIDGE}/beat")):
            found = f"it runs, and does not hear {_words(bridges)}, or the driver does not hear it"
            step = "its log; ROS_IP of both hosts, guard.bridge; rosnode cleanup after a dead one"
            return CheckResult(name, False, found, step)
        return CheckResult(name, True, "it runs, waits for the bridge")

    def _nodes(self, by_topic: Mapping[str, Sequence[str]] | None, topic: str) -> list[str] | None:
        if by_topic is None:
            return None
        return sorted(by_topic.get(self._named(f"/{self._arm.namespace}/{topic}"), ()))

    def _joints(self, seen: Observed, state: JointFeedback) -> Vector:
        """All ten joints [rad]; a tool that says nothing counts as straight."""
        tool = np.zeros(3) if seen.tool is None else seen.tool.position
        return np.concatenate([state.position, tool])


def _words(nodes: Sequence[str]) -> str:
    return ", ".join(nodes) if nodes else "nobody"


def table(results: Sequence[CheckResult]) -> str:
    """The results as text, one line each, with the next step where one is needed."""
    width = max(len(result.name) for result in results)
    lines = []
    for result in results:
        mark = {True: "ok", False: "NO", None: "?"}[result.is_met]
        step = f"  -> {result.next_step}" if result.is_met is False and result.next_step else ""
        lines.append(f"{mark:<3}{result.name:<{width}}  {result.found}{step}")
    return "\n".join(lines)

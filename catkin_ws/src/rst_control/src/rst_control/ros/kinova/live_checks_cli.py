# SPDX-License-Identifier: BSD-3-Clause
"""`rosrun rst_control kinova_checks`: looks at live drivers, moves nothing, prints a table."""

from __future__ import annotations

import argparse
import sys
import threading
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import rospy
from geometry_msgs.msg import WrenchStamped
from kortex_driver.msg import BaseCyclic_Feedback
from sensor_msgs.msg import JointState
from std_msgs.msg import Empty, Int32MultiArray

from rst_control.config import CONFIG_FOLDER, URDF_FILE, RcmConfig
from rst_control.config.torque_tension import TORQUE_TENSION_FILE
from rst_control.errors import RstError
from rst_control.kinova.arm_state import ArmReport, SoftLimits
from rst_control.kinova.config import KinovaConfig
from rst_control.kinova.feedback import BadFeedback, FeedbackReader, JointFeedback, rows_of
from rst_control.kinova.live_checks import LiveChecks, Observed, table
from rst_control.kinova.preflight import REACH
from rst_control.ros.kinova.arm_report import ask_firmware, ask_limits, read_report
from typed_config import (
    ConfigError,
    add_common_options,
    load_config,
    load_file,
    load_yaml,
    number_option,
    overlaid,
    place_option,
)
from typed_config.ros.system_names import of_this_system
from typed_config.ros.xmlrpc import FAILURES, ask_master, master_problem


@dataclass
class _Heard:
    """What came so far; filled by threads of rospy."""

    arm: list[JointFeedback] = field(default_factory=list)
    bad_feedback: str = ""
    reports: list[ArmReport] = field(default_factory=list)
    clock: float | None = None
    tool: JointFeedback | None = None
    bad_tool: str = ""
    tool_state: int | None = None
    guard_beats: int = 0
    forces: list[Any] = field(default_factory=list)


class _Observer:
    """Subscribes to all that the drivers report, and publishes nothing."""

    def __init__(self, config: KinovaConfig) -> None:
        self._heard, self._lock = _Heard(), threading.Lock()
        arm, tool = config.bridge.arm, config.bridge.tool
        self._arm = FeedbackReader(arm.joints, (1.0,) * len(arm.joints), config.first_turns)
        self._tool = FeedbackReader(tool.joints, tool.signs, None)
        topics = (
            (f"{arm.namespace}/base_feedback/joint_state", JointState, self._on_arm),
            (f"{arm.namespace}/base_feedback", BaseCyclic_Feedback, self._on_report),
            (f"{tool.namespace}/joint_states", JointState, self._on_tool),
            (f"{tool.namespace}/openrst_state", Int32MultiArray, self._on_state),
            ("robot/tension_sensor", WrenchStamped, self._on_force),
            ("kinova_guard/alive", Empty, self._on_guard),
        )
        *_, self._guard = [
            rospy.Subscriber(topic, kind, callback, tcp_nodelay=True)
            for topic, kind, callback in topics
        ]

    def take(self) -> _Heard:
        """What came since this was last called."""
        with self._lock:
            heard, self._heard = self._heard, _Heard()
        return heard

    @property
    def is_guard_connected(self) -> bool:
        """The stop guard runs, whether it beats or not."""
        return self._guard.get_num_connections() > 0

    def _on_arm(self, message: JointState) -> None:
        arrived = time.monotonic()
        with self._lock:
            self._heard.clock = time.time() - message.header.stamp.to_sec()
            try:
                self._heard.arm.append(self._arm.read(message.name, rows_of(message), arrived))
            except BadFeedback as error:
                self._heard.bad_feedback = str(error)

    def _on_report(self, message: BaseCyclic_Feedback) -> None:
        with self._lock:
            self._heard.reports.append(read_report(message, time.monotonic()))

    def _on_tool(self, message: JointState) -> None:
        with self._lock:
            try:
                now = time.monotonic()
                self._heard.tool = self._tool.read(message.name, rows_of(message), now)
            except BadFeedback as error:
                self._heard.bad_tool = str(error)

    def _on_state(self, message: Int32MultiArray) -> None:
        with self._lock:
            self._heard.tool_state = message.data[0] if message.data else -1

    def _on_force(self, message: WrenchStamped) -> None:
        force = message.wrench.force
        with self._lock:
            self._heard.forces.append(np.array([force.x, force.y, force.z]))

    def _on_guard(self, _: Empty) -> None:
        with self._lock:
            self._heard.guard_beats += 1


def _observed(observer: _Observer, seconds: float, arm: str) -> Observed:
    time.sleep(1.0)  # until subscribers are connected
    observer.take()
    time.sleep(seconds)
    heard = {**vars(observer.take()), **_facts(arm)}
    heard["is_guard_connected"] = observer.is_guard_connected
    try:
        state: Any = ask_master("getSystemState")
    except FAILURES:
        return Observed(seconds, **heard)
    publishers, subscribers, _ = state
    return Observed(seconds, **heard, publishers=dict(publishers), subscribers=dict(subscribers))


def _facts(arm: str) -> dict[str, SoftLimits | str]:
    """What the arm says of its limits and its firmware; without what it does not say."""
    found: dict[str, SoftLimits | str] = {}
    with suppress(rospy.ServiceException, rospy.ROSException):
        found["limits"] = ask_limits(arm)
    with suppress(rospy.ServiceException, rospy.ROSException):
        found["firmware"] = ask_firmware(arm)
    return found


def main(argv: Sequence[str] | None = None) -> None:
    """Observe, print, and end with 1 where something is not as it has to be; 2: not observed."""
    parser = argparse.ArgumentParser(prog="kinova_checks", description=__doc__)
    parser.add_argument("--trocar", type=place_option(REACH), metavar='"X Y Z"')
    parser.add_argument("--limits", type=Path, default=CONFIG_FOLDER / "kinova_limits.yaml")
    parser.add_argument("--scene", type=Path, default=CONFIG_FOLDER / "scene.yaml")
    parser.add_argument("--urdf", type=Path, default=URDF_FILE, help="description of the robot")
    parser.add_argument("--arm", default="my_gen3", help="namespace of Kinova's driver")
    parser.add_argument("--tool", default="openrst", help="namespace of OpenRST's node")
    parser.add_argument("--torques", type=Path, default=TORQUE_TENSION_FILE)
    parser.add_argument(
        "--bridge-overrides", type=Path, help="YAML file with settings of the bridge to change"
    )
    parser.add_argument("--seconds", type=number_option(0.5, 600.0, "s"), default=3.0)
    add_common_options(parser, "rst_control")
    given = parser.parse_args(rospy.myargv(sys.argv)[1:] if argv is None else argv)
    try:
        checks, config = _checks(given)
    except (RstError, ConfigError, OSError, UnicodeDecodeError) as error:
        parser.error(str(error))
    if words := master_problem():
        parser.error(words)
    rospy.init_node("kinova_checks", anonymous=True, disable_signals=True)
    results = checks(_observed(_Observer(config), given.seconds, config.bridge.arm.namespace))
    print(table(results), flush=True)
    sys.exit(int(any(result.is_met is False for result in results)))


def _checks(given: argparse.Namespace) -> tuple[LiveChecks, KinovaConfig]:
    config = _config(given)
    rcm = load_file(RcmConfig, CONFIG_FOLDER / "rcm.yaml")
    trocar = np.array(given.trocar or config.scene.trocar)
    description = given.urdf.read_text(encoding="utf-8")
    checks = LiveChecks(config, trocar, description, rcm.measured_tolerance, of_this_system)
    return checks, config


def _config(given: argparse.Namespace) -> KinovaConfig:
    """What the bridge would have with the same arguments of kinova.launch; overrides come last.

    The drivers are believed, and their simulation as well.
    """
    merged: Mapping[str, object] = {
        "limits": load_yaml(given.limits),
        "scene": load_yaml(given.scene),
        "torques": load_yaml(given.torques),
        "bridge": load_yaml(CONFIG_FOLDER / "kinova_bridge.yaml"),
    }
    names = {
        "arm": {"namespace": given.arm},
        "tool": {"namespace": given.tool},
        "believed": {"arm": ["/robot", f"/{given.arm}/*"], "tool": ["/robot", f"/{given.tool}/*"]},
    }
    merged = overlaid(merged, {"bridge": names})
    if given.bridge_overrides is not None:
        merged = overlaid(merged, load_yaml(given.bridge_overrides))
    return load_config(KinovaConfig, merged, "settings of the bridge")


if __name__ == "__main__":
    main()

# SPDX-License-Identifier: BSD-3-Clause
"""What launch/kinova.launch asks before it starts anything; it refuses in a sentence.

roslaunch runs it while it reads the launch file, and ends where it ends with an error.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from rst_control.config import CONFIG_FOLDER, URDF_FILE, LimitsConfig, RcmConfig, SceneConfig
from rst_control.errors import RstError
from rst_control.kinematics.configuration import Configuration
from rst_control.kinematics.joint_limits import require_ranges
from rst_control.kinematics.rcm import rcm_state
from rst_control.kinematics.robot_model import RobotModel, load_robot
from typed_config import ConfigError, add_common_options, load_file, place_option

REACH = 1.6  # [m] from base_link, beyond which no trocar is
STOP_WORDS = (
    "there must be an emergency stop within reach of a hand, tried today: say so by "
    "i_have_an_emergency_stop:=true"
)


SWITCHES = ("true", "false")  # in $(eval ...), roslaunch takes 0 and "" for false, others for true


class NotReady(RstError):
    """The robot may not be started like this."""


def check(
    has_stop: bool,
    is_simulated: bool,
    trocar: Sequence[float],
    limits: Path,
    scene: Path,
    scale: float,
    urdf: Path = URDF_FILE,
) -> str:
    """Check what a start with the real robot needs.

    Args:
        has_stop: Somebody said that there is an emergency stop.
        is_simulated: No hardware is there.
        trocar: As measured, base frame, [m]. Shape (3,).
        limits: File of joint limits.
        scene: File of the scene, whose home has the shaft in the trocar.
        scale: Of all speeds.
        urdf: Description of the robot.

    Returns:
        What holds, in words.

    Raises:
        NotReady: Says what is missing, and what to do.
        ConfigError: A file is wrong; names the key.
        RobotModelError: The description is wrong, or limits are beyond the ranges of its joints.
        OSError: It cannot be read.
    """
    if not has_stop and not is_simulated:
        raise NotReady(STOP_WORDS)
    distance = math.hypot(*trocar)
    if not distance <= REACH:
        words = ", ".join(f"{x:g}" for x in trocar)
        raise NotReady(
            f"the trocar ({words}) m is {distance:.3f} m from base_link, allowed up to {REACH} m: "
            "give trocar_x, trocar_y and trocar_z as measured"
        )
    if not 0.0 < scale <= 1.0:
        raise NotReady(f"speed_scale is {scale:g}, allowed above 0, up to 1")
    bounds = load_file(LimitsConfig, limits)
    home = load_file(SceneConfig, scene)
    _check_turns(home, bounds, scene)
    model = load_robot(urdf)
    require_ranges(bounds, model)
    _check_home(home, trocar, scene, model)
    what = "simulated drivers" if is_simulated else "the real robot"
    return f"{what}, limits {bounds.layer}, speeds times {scale:g}"


def _check_turns(scene: SceneConfig, limits: LimitsConfig, file: Path) -> None:
    """Home is in the angles that the driver reports, not in those of the robot's web page."""
    ends = zip(scene.home, limits.arm_lower, limits.arm_upper, strict=False)
    for joint, (angle, low, high) in enumerate(ends, 1):
        if not max(low, -math.pi) <= angle <= min(high, math.pi):
            reported = math.remainder(angle, math.tau)
            raise NotReady(
                f"home of {file} has joint_{joint} at {angle:.3f} rad, allowed "
                f"{max(low, -math.pi):.3f} to {min(high, math.pi):.3f} rad: the web page counts "
                f"from 0 to 360 degrees, the driver reports {reported:.3f} rad; give that"
            )


def _check_home(scene: SceneConfig, trocar: Sequence[float], file: Path, model: RobotModel) -> None:
    """The posture from which everything is planned must have the shaft in the trocar."""
    rcm = load_file(RcmConfig, CONFIG_FOLDER / "rcm.yaml")
    home = Configuration(model, np.array(scene.home))
    error, allowed = rcm_state(home, np.array(trocar)).error, rcm.measured_tolerance
    if error > allowed:
        raise NotReady(
            f"home of {file} leads the shaft {error * 1e3:.1f} mm past the trocar, allowed "
            f"{allowed * 1e3:.1f} mm: lead the shaft into it, read the joints, and give a scene of "
            "your own by scene:=<file>"
        )


def is_on(name: str, value: str) -> bool:
    """What a switch of the launch says, in letters of any case, as roslaunch takes them.

    Raises:
        NotReady: It says neither true nor false; names the argument.
    """
    if value.lower() not in SWITCHES:
        raise NotReady(f"{name} is {value!r}, allowed: {' or '.join(SWITCHES)}")
    return value.lower() == "true"


def main(argv: Sequence[str] | None = None) -> None:
    """Check, print what holds, or end with the reason on the error output."""
    parser = argparse.ArgumentParser(prog="kinova_preflight", description=__doc__)
    for switch in ("--emergency-stop", "--simulate", "--in-air", "--dry-run"):
        parser.add_argument(switch, required=True, metavar="{true,false}")
    parser.add_argument("--trocar", type=place_option(REACH), required=True, metavar='"X Y Z"')
    parser.add_argument("--limits", type=Path, required=True)
    parser.add_argument("--scene", type=Path, required=True)
    parser.add_argument("--urdf", type=Path, default=URDF_FILE)
    parser.add_argument("--speed-scale", type=float, required=True)
    add_common_options(parser, "rst_control")
    given = parser.parse_args(argv)
    try:
        for name in ("in_air", "dry_run"):  # what they say reaches the controller by the launch
            is_on(name, getattr(given, name))
        words = check(
            is_on("i_have_an_emergency_stop", given.emergency_stop),
            is_on("simulate", given.simulate),
            given.trocar,
            given.limits,
            given.scene,
            given.speed_scale,
            given.urdf,
        )
    except (RstError, ConfigError, OSError) as error:
        print(f"\nkinova.launch does not start: {error}\n", file=sys.stderr)
        sys.exit(2)
    print(words)

# SPDX-License-Identifier: BSD-3-Clause
"""Fits the trocar to a recording in which the shaft was tilted in it from rest to rest.

The robot stands in at least five poses, moved by hand or by commands; `set_trocar` then takes the
printed point, or scene.yaml does.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from rst_control.config import CONFIG_FOLDER, URDF_FILE, MotionConfig, load_motion_config
from rst_control.errors import RstError
from rst_control.kinematics.configuration import robot_joints
from rst_control.kinematics.robot_model import load_robot
from rst_control.registration.pivot_calibration import PivotFit, fit_pivot
from rst_control.registration.pose_file import ArmSample, read_arm, rest_poses
from rst_control.registration.shaft_poses import fit_objection, fit_words, shaft_line
from rst_control.types import Vector
from typed_config import ConfigError, add_common_options, number_option, run_command


def main(words: Sequence[str] | None = None) -> None:
    """Run the command line; exits with 0, or with 1 and what is wrong."""
    arguments, refusals = _parser().parse_args(words), (RstError, ConfigError)
    if status := run_command(lambda: _calibrate(arguments), "calibrate_trocar", refusals, failed=1):
        sys.exit(status)


class NoTrocar(RstError):
    """The poses have no point in common that is good enough to be the trocar."""


def _calibrate(arguments: argparse.Namespace) -> None:
    config = load_motion_config(arguments.config)
    poses, fit = _fit(arguments, config)
    if not arguments.moving and any(np.isnan(pose.speed) for pose in poses):
        print("The file has no velocities, so poses in motion count, too.")
    print(_report(poses, fit))
    if objection := fit_objection(fit, config.rcm.registration.tolerance):
        raise NoTrocar(objection)
    x, y, z = (f"{value:.6f}" for value in fit.position)
    print(f"trocar: [{x}, {y}, {z}]   # for scene.yaml")
    print(f'rosservice call /rst_control/set_trocar "position: {{x: {x}, y: {y}, z: {z}}}"')


def _fit(arguments: argparse.Namespace, config: MotionConfig) -> tuple[list[ArmSample], PivotFit]:
    model = load_robot(arguments.urdf)
    rest = config.controller.watchdogs.at_rest_speed
    samples = read_arm(arguments.file, arguments.topic)
    span = (arguments.since, arguments.until)
    poses = rest_poses(samples, arguments.apart, np.inf if arguments.moving else rest, span)
    lines = [shaft_line(model, _joints(pose.position)) for pose in poses]
    points, directions = [line[0] for line in lines], [line[1] for line in lines]
    settings = config.rcm.registration
    return poses, fit_pivot(points, directions, settings.min_poses, settings.min_spread)


def _report(poses: Sequence[ArmSample], fit: PivotFit) -> str:
    lines = [fit_words(fit)]
    for number, (pose, residual) in enumerate(zip(poses, fit.residuals, strict=True), 1):
        lines.append(f"pose {number}, {pose.time:.1f} s: {residual * 1e3:.3f} mm")
    return "\n".join(lines)


def _joints(arm: Vector) -> Vector:
    """Joints of the robot (10,) [rad] with the tool straight, which does not move the shaft."""
    return robot_joints(np.concatenate([arm, np.zeros(2)]), 0.0)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="calibrate_trocar", description=__doc__)
    parser.add_argument("file", type=Path, help="MCAP file, folder of a session, or CSV of joints")
    parser.add_argument("--topic", default="/joint_states", help="of the joint states in an MCAP")
    time, angle = number_option(0.0, unit="s"), number_option(0.0, np.pi, "rad")
    of_file = "[s] from the start of the file"
    parser.add_argument("--since", type=time, default=0.0, help=of_file)
    parser.add_argument("--until", type=time, default=np.inf, help=f"{of_file}; default: its end")
    parser.add_argument(
        "--apart", type=angle, default=0.01, help="[rad] least change of a joint between two poses"
    )
    parser.add_argument("--moving", action="store_true", help="take poses in motion, too")
    parser.add_argument(
        "--config", type=Path, default=CONFIG_FOLDER, help="folder of the settings' YAML files"
    )
    parser.add_argument("--urdf", type=Path, default=URDF_FILE, help="description of the robot")
    add_common_options(parser, "rst_control")
    return parser

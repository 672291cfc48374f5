# SPDX-License-Identifier: BSD-3-Clause
"""The robot, its settings, its planner and its verifier, as fixtures."""

from tests.support.motion_fixtures import gate, home, joints, motion_config, planner, robot, verify

__all__ = ["gate", "home", "joints", "motion_config", "planner", "robot", "verify"]

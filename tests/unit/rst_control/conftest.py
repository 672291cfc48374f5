# SPDX-License-Identifier: BSD-3-Clause
"""The robot, its settings and its planner, as fixtures."""

from tests.support.motion_fixtures import home, motion_config, planner, robot

__all__ = ["home", "motion_config", "planner", "robot"]

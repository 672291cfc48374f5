# SPDX-License-Identifier: BSD-3-Clause
"""The robot, its settings, its planner and its verifier, as fixtures."""

import pytest

from tests.support.motion_fixtures import gate, home, joints, motion_config, planner, robot, verify

__all__ = ["gate", "home", "joints", "motion_config", "planner", "robot", "verify"]


@pytest.fixture(scope="session")
def witness(motion_config):
    """PyBullet's view of the robot at any joints."""
    from bench.motion.bullet.witness import BulletWitness  # with PyBullet, for two files

    with BulletWitness(motion_config) as made:
        yield made

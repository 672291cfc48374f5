#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""A session with the simulated robot that is not ideal: its messages late, its joints off."""

import unittest

import numpy as np

from tests.support.robot_client import RobotClient, run_tests

STEP = 4.8e-5  # [rad] of the arm's encoders (plant.yaml)


class LabPlant(unittest.TestCase):
    """Commands are carried out in it; what is measured shows its encoders."""

    def test_commands_are_carried_out(self):
        robot = RobotClient()
        counts = np.array(robot.joints.position[:7]) / STEP
        np.testing.assert_allclose(counts, np.round(counts), atol=1e-6)
        robot.activate()
        for command in ("tense", "pull more", "release"):
            robot.say_and_finish(command, 90.0)
        self.assertEqual(robot.halts(), [])
        robot.leave()


if __name__ == "__main__":
    run_tests(LabPlant, "lab_plant")

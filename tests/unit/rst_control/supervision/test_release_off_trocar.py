# SPDX-License-Identifier: BSD-3-Clause
"""With the shaft pushed off the trocar held tissue is let go, and nothing moves the arm."""

import numpy as np
import pytest

from rst_control.types import Reason, State
from tests.unit.rst_control.support.executor_rig import Rig


def holding():
    rig = Rig().believing().awake()
    rig.finish("tense")
    return rig


def push(rig):
    """Turn joint 4 off its course; from then on the jaws alone follow."""
    robot = rig.robot
    robot.push(np.eye(10)[3] * 0.01)
    arm = robot.measured_js().position[:8].copy()

    def follow(setpoint):
        robot._position = np.r_[arm, setpoint.position[8:]]

    robot.servo_jp = follow
    rig.tick()
    assert rig.view.rcm_error > rig.config.rcm.measured_tolerance


def test_tissue_is_released_and_the_arm_stays():
    rig = holding()
    push(rig)
    arm = rig.joints[:8].copy()
    rig.finish("release")
    assert not rig.view.is_tissue_held and rig.state is State.ACTIVE
    np.testing.assert_array_equal(rig.joints[:8], arm)


@pytest.mark.parametrize("words", ["pull more", "pull less"])
def test_no_pull_begins_before_and_no_motion_after_the_release(words):
    rig = holding()
    push(rig)
    assert "off the trocar" in rig.refused(words)
    rig.finish("release")
    assert "off the trocar" in rig.refused("tense")


def test_a_release_that_was_to_ease_off_brakes_before_the_arm_has_moved():
    rig = holding()
    arm = rig.joints[:8].copy()
    rig.say("release")
    push(rig)
    rig.run(0.05)
    assert rig.phase == "open"
    rig.until(lambda: rig.state is State.FAULTED)
    assert rig.view.mode.cause.reason is Reason.OFF_TROCAR
    assert not rig.view.is_tissue_held
    np.testing.assert_allclose(rig.joints[:8], arm, atol=1e-6)


def test_on_the_trocar_a_release_eases_off():
    rig = holding()
    arm = rig.joints[:8].copy()
    rig.finish("release")
    assert np.abs(rig.joints[:8] - arm).max() > 1e-3

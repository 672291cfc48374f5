# SPDX-License-Identifier: BSD-3-Clause
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from rst_control.kinematics.robot_model import rotation
from rst_control.kinematics.rotations import quaternion, roll_pitch_yaw, rotation_of


@pytest.mark.parametrize("turn", Rotation.random(20, random_state=1))
def test_a_matrix_is_the_same_rotation_in_every_form(turn):
    R = turn.as_matrix()
    np.testing.assert_allclose(Rotation.from_quat(quaternion(R)).as_matrix(), R, atol=1e-12)
    np.testing.assert_allclose(rotation_of(3.0 * turn.as_quat()), R, atol=1e-12)
    np.testing.assert_allclose(rotation(roll_pitch_yaw(R)), R, atol=1e-12)

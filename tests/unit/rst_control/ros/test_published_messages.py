# SPDX-License-Identifier: BSD-3-Clause
"""Our stand-ins for other people's messages have their md5 sums, so that others accept them."""

import control_msgs.msg
import kortex_driver.msg
import openrst_control.srv
import pytest

# Each sum was found in code that others generated from the published definitions (ROS 1): rosserial
# and roslisp headers of control_msgs, roslisp and JavaScript ones of kortex_driver. No generated
# code of OpenRST is public: its sum is that of its published definition, "string message" asking
# and "bool succeeded" answering.
PUBLISHED = {
    control_msgs.msg.JointTolerance: "f544fe9c16cf04547e135dd6063ff5be",
    control_msgs.msg.FollowJointTrajectoryAction: "bc4f9b743838566551c0390c65f1a248",
    control_msgs.msg.FollowJointTrajectoryGoal: "69636787b6ecbde4d61d711979bc7ecb",
    control_msgs.msg.FollowJointTrajectoryActionGoal: "cff5c1d533bf2f82dd0138d57f4304bb",
    control_msgs.msg.FollowJointTrajectoryResult: "493383b18409bfb604b4e26c676401d2",
    control_msgs.msg.FollowJointTrajectoryActionResult: "c4fb3b000dc9da4fd99699380efcc5d9",
    control_msgs.msg.FollowJointTrajectoryFeedback: "10817c60c2486ef6b33e97dcd87f4474",
    control_msgs.msg.FollowJointTrajectoryActionFeedback: "d8920dc4eae9fc107e00999cce4be641",
    kortex_driver.msg.JointSpeed: "fd26fce9b45cd51d86512ba0cf80d2bd",
    kortex_driver.msg.Base_JointSpeeds: "f323c64d027d947f420c021696580eb4",
    openrst_control.srv.openrst_request: "e911a08d7434cb6ed4be9e08553a1ced",
}
NAMES = {
    control_msgs.msg.FollowJointTrajectoryAction: "control_msgs/FollowJointTrajectoryAction",
    kortex_driver.msg.Base_JointSpeeds: "kortex_driver/Base_JointSpeeds",
    openrst_control.srv.openrst_request: "openrst_control/openrst_request",
}


@pytest.mark.parametrize("kind", PUBLISHED, ids=lambda kind: kind._type)
def test_md5_sum_is_the_published_one(kind):
    assert kind._md5sum == PUBLISHED[kind]


@pytest.mark.parametrize("kind", NAMES, ids=lambda kind: kind._type)
def test_type_has_the_published_name(kind):
    assert kind._type == NAMES[kind]


def test_error_codes_are_the_published_ones():
    codes = {
        "SUCCESSFUL": 0,
        "INVALID_GOAL": -1,
        "INVALID_JOINTS": -2,
        "OLD_HEADER_TIMESTAMP": -3,
        "PATH_TOLERANCE_VIOLATED": -4,
        "GOAL_TOLERANCE_VIOLATED": -5,
    }
    result = control_msgs.msg.FollowJointTrajectoryResult
    assert {name: getattr(result, name) for name in codes} == codes

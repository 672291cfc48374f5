# SPDX-License-Identifier: BSD-3-Clause
"""Our stand-ins for other people's messages have their md5 sums, so that others accept them."""

import audio_common_msgs.msg
import control_msgs.msg
import crtk_msgs.msg
import kortex_driver.msg
import kortex_driver.srv
import openrst_control.srv
import pytest
import speech_recognition_msgs.msg

# Each sum was found in code that others generated from the published definitions (ROS 1): rosserial
# and roslisp headers of control_msgs, roslisp and JavaScript ones of kortex_driver. No generated
# code of OpenRST is public: its sum is that of its published definition, "string message" asking
# and "bool succeeded" answering. Of the others: JavaScript messages of audio_common_msgs, rosserial
# headers of speech_recognition_msgs and crtk_msgs. The sum of StringStamped was found as
# that of robotnik_msgs/StringStamped, which has the same fields.
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
    kortex_driver.msg.BaseCyclic_Feedback: "5f56809f61aebc2804399d7366b38f65",
    kortex_driver.srv.GetKinematicSoftLimits: "8372b01bbf6aa0f718ce44248decf90a",
    kortex_driver.srv.GetFirmwareBundleVersions: "8a198c1bd1965cc2d1e06f5a3548e004",
    audio_common_msgs.msg.AudioData: "f43a8e1b362b75baa741461b46adc7e0",
    audio_common_msgs.msg.AudioInfo: "9413d9b7029680d3b1db6ed0ae535f88",
    crtk_msgs.msg.StringStamped: "5e3e46086181199270f1ac3a28a5977f",
    crtk_msgs.msg.operating_state: "b1bd4021639d9d9c5fbfff78d6ff3158",
    speech_recognition_msgs.msg.SpeechRecognitionCandidates: "8bf91ae2b1d4cbc38dce17013599f915",
    openrst_control.srv.openrst_request: "e911a08d7434cb6ed4be9e08553a1ced",
}


@pytest.mark.parametrize("kind", PUBLISHED, ids=lambda kind: kind._type)
def test_md5_sum_is_the_published_one(kind):
    assert kind._md5sum == PUBLISHED[kind]


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

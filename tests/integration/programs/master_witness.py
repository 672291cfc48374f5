# SPDX-License-Identifier: BSD-3-Clause
"""Finds robot and controller by a master that was started anew, and leads them.

Prints the first state that it hears, and the reason of a latch.
"""

import json

import rospy

from tests.support.robot_client import RobotClient

rospy.init_node("master_witness")
robot = RobotClient()
print(json.dumps([robot.state.state, robot.state.halt_reason]), flush=True)
robot.start_fresh()  # the motion may have come as far as to grasp
robot.say("tense")
robot.say("stop")
robot.wait_for_state("halted")

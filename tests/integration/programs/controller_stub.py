# SPDX-License-Identifier: BSD-3-Clause
"""Answers the voice node's calls in place of the controller; for test_session_replay.py.

Argument: a file to touch once the service is there. "tense" is refused, everything else accepted.
"""

import sys
from pathlib import Path

import rospy

from rst_control.srv import Command, CommandResponse


def answer(request):
    if request.command == "tense":
        return CommandResponse(False, "nothing is grasped", "nothing_grasped")
    return CommandResponse(True, f"{request.command} it is", "")


rospy.init_node("controller")
rospy.Service("rst_control/command", Command, answer)
Path(sys.argv[1]).touch()
rospy.spin()

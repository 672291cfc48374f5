# SPDX-License-Identifier: BSD-3-Clause
"""Leads the arm into a motion, kills the bridge, and writes down what the arm did.

Argument: file to write. It runs outside of every launch, for roslaunch ends all with the bridge.
"""

import json
import os
import signal
import sys
from pathlib import Path

import numpy as np
import rospy
from sensor_msgs.msg import JointState
from std_msgs.msg import Empty

from rst_control.types import ARM_JOINTS
from support.raw_peer import process_of
from tests.support.robot_client import RobotClient

MOVING = 0.02  # [rad/s] of the fastest joint, in whose midst the bridge dies
FRESH = 0.2  # [s] age of that speed, at most: on a loaded machine it may be of long ago
WATCHED = 6.0  # [s] after that, of the arm's time


def main() -> None:
    seen, stops = [], []
    rospy.init_node("arm_witness")

    def on_joints(message):
        order = [message.name.index(name) for name in ARM_JOINTS]
        speed = np.abs(np.array(message.velocity)[order]).max()
        seen.append((message.header.stamp.to_sec(), speed, np.array(message.position)[order]))

    rospy.Subscriber("simulation/joint_states", JointState, on_joints, tcp_nodelay=True)
    rospy.Subscriber("my_gen3/in/stop", Empty, stops.append)
    robot = RobotClient()
    robot.home_tool()
    robot.start_fresh()
    bridge = process_of("kinova_bridge")  # before: the answer may take as long as the reach
    robot.say("tense")
    robot.wait(lambda: seen[-1][1] > MOVING and rospy.get_time() - seen[-1][0] < FRESH)
    before = len(stops)
    os.kill(bridge, signal.SIGKILL)
    killed = rospy.get_time()  # what is stamped earlier and comes later is of before
    robot.wait(lambda: seen[-1][0] > killed + WATCHED)
    after = [one for one in seen if one[0] > killed]
    late = [place for t, _, place in after if t > killed + 0.5 * WATCHED]
    resting = [t for t, speed, _ in after if speed < 1e-3]
    found = {
        "speed": float(next(speed for t, speed, _ in reversed(seen) if t <= killed)),
        "stops": len(stops) - before,
        "rest": resting[0] - killed if resting else None,
        "last_speed": float(after[-1][1]),
        "drift": float(np.abs(late[-1] - late[0]).max()),
        "seen": after[-1][0] - killed,
    }
    Path(sys.argv[1]).write_text(json.dumps(found), encoding="utf-8")


main()

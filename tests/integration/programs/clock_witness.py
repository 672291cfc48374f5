# SPDX-License-Identifier: BSD-3-Clause
"""Sets the wall clock of running nodes in mid-motion, and writes down what the robot did.

Arguments: the jumps of each clock in JSON; by the same names the files that say how far each is off
(`other_clock`), in JSON; and the file to write. A tool that has to be homed is homed.
"""

import json
import sys
import time
from pathlib import Path

import numpy as np
import rospy
import rosservice
from sensor_msgs.msg import JointState

from rst_control.types import ARM_COUNT
from tests.support.robot_client import MOVING, RobotClient

RESTING = 1e-4  # [rad] in half a second
WATCHED = 1.0  # [s] after that, twice as long as the oldest joint states that are believed


def main() -> None:
    jumps_of = json.loads(sys.argv[1])  # [s] each in a motion, and back again at rest
    clocks, results = json.loads(sys.argv[2]), Path(sys.argv[3])
    rospy.init_node("clock_witness")
    seen = []
    rospy.Subscriber(
        "joint_states", JointState, lambda m: seen.append(np.array(m.position)), tcp_nodelay=True
    )
    robot = RobotClient()
    found = []
    if rospy.resolve_name("robot/home_tool") in rosservice.get_service_list():
        robot.home_tool()
    for whose, jump in [(name, jump) for name, jumps in jumps_of.items() for jump in jumps]:
        robot.start_fresh()
        robot.say("tense")
        robot.wait(lambda: robot.state.phase == "reach" and arm_speed(robot) > MOVING)
        for at in (jump, 0.0):
            seen.clear()
            put_off(Path(clocks[whose]), at)
            time.sleep(WATCHED)
            found.append({"whose": whose, "jump": at or -jump, **after(robot, seen)})
    robot.start_fresh()
    robot.say_and_finish("tense")
    results.write_text(json.dumps(found), encoding="utf-8")


def arm_speed(robot: RobotClient) -> float:
    """Of the joints that the reach alone moves [rad/s]: the jaws may still come to rest."""
    return max(abs(v) for v in robot.joints.velocity[:ARM_COUNT])


def put_off(clock: Path, seconds: float) -> None:
    """Set the nodes' wall clock so far ahead of the machine's."""
    new = clock.with_suffix(".new")
    new.write_text(str(seconds), encoding="utf-8")
    new.rename(clock)


def after(robot: RobotClient, seen: list) -> dict:
    """What came of it: where the robot went, and whether it can be stopped and woken."""
    robot.wait(lambda: robot.state.state != "stopping")
    state, reason = robot.state.state, robot.state.halt_reason
    path = np.array(seen)
    if state in ("moving", "active"):  # it may have come to the end of its motion
        robot.say("stop")
        robot.wait_for_state("halted", "faulted")
    robot.wait(lambda: robot.drift(0.5) < RESTING)  # with a clock ahead it plays all out later
    drift = robot.drift(0.5)
    refused = robot.refused("tense")
    return {
        "state": state,
        "reason": reason,
        "refused": refused,
        "drift": drift,
        "step": float(np.abs(np.diff(path, axis=0)).max()) if len(path) > 1 else 0.0,
        "rcm": robot.max_rcm_error(),
    }


main()

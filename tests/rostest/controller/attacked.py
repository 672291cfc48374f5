#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Messages of a stranger on every topic, a cancel and a goal at once, a second controller."""

import subprocess

import rosgraph
import roslib.message
import rospy
from actionlib_msgs.msg import GoalID

from rst_control.msg import AssistActionGoal, AssistActionResult
from support.waiting import PATIENCE
from tests.support.robot_client import RobotTest, run_tests

NODES = ("/controller", "/robot")
STOPS = ("/rst_control/stop", "/rst_control/execute/cancel")  # anybody may stop
TIMES, EVERY = 40, 0.02  # that each is published, and [s] between
STILL = 1e-4  # [rad]


def subscribed_topics():
    """Topics that the system listens to, with their types."""
    master = rosgraph.Master(rospy.get_name())
    _, subscribers, _ = master.getSystemState()
    types = dict(master.getTopicTypes())
    heard = [topic for topic, nodes in subscribers if set(nodes) & set(NODES)]
    return {topic: types[topic] for topic in heard if types.get(topic, "*") != "*"}


def plausible(kind):
    """A message of a type with a stamp of now, as a forgotten program would send it."""
    message = kind()
    if hasattr(message, "header"):
        message.header.stamp = rospy.Time.now()
    return message


class Attacked(RobotTest):
    """In the order of their names, on one robot."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.goal = rospy.Publisher("rst_control/execute/goal", AssistActionGoal, queue_size=5)
        cls.cancel = rospy.Publisher("rst_control/execute/cancel", GoalID, queue_size=5)
        cls.results = []  # whose sender does not hear of its end is no goal
        rospy.Subscriber("rst_control/execute/result", AssistActionResult, cls.results.append)
        cls.robot.wait(lambda: cls.goal.get_num_connections() and cls.cancel.get_num_connections())

    def flood(self):
        """Publish on every topic that the system hears but those of a stop; returns which."""
        topics = {name: kind for name, kind in subscribed_topics().items() if name not in STOPS}
        kinds = {name: roslib.message.get_message_class(kind) for name, kind in topics.items()}
        publishers = {name: rospy.Publisher(name, kinds[name], queue_size=5) for name in topics}
        self.robot.wait(lambda: all(p.get_num_connections() for p in publishers.values()))
        for _ in range(TIMES):
            for name, publisher in publishers.items():
                publisher.publish(plausible(kinds[name]))
            rospy.sleep(EVERY)
        for publisher in publishers.values():
            publisher.unregister()
        return topics

    def assert_still(self, place):
        self.assertLess(self.robot.away(place), STILL)

    def test_1_a_stranger_on_every_topic_moves_nothing_of_an_active_robot(self):
        self.robot.start_fresh()
        place = self.robot.joints.position
        topics = self.flood()
        for needed in ("/robot/servo_jp", "/joint_states", "/robot/gripped", "/robot/hold"):
            self.assertIn(needed, topics)
        self.assert_still(place)
        self.assertEqual(self.robot.state.state, "active")

    def test_2_nor_does_it_unlatch_anything(self):
        self.robot.say("stop")
        self.robot.wait_for_state("halted")
        place = self.robot.joints.position
        self.flood()
        self.assert_still(place)
        self.assertEqual(self.robot.state.state, "halted")

    def test_3_a_motion_meanwhile_reaches_its_end(self):
        self.robot.start_fresh()
        count, halts = self.robot.finished("tense"), len(self.robot.halts())
        self.robot.say("tense")
        self.flood()
        self.robot.finish("tense", count, halts, 40.0)
        self.assertTrue(self.robot.state.tissue_held)

    def send_goal(self, command, name):
        message = AssistActionGoal()
        message.goal_id.id, message.goal.command = name, command
        message.goal_id.stamp = message.header.stamp = rospy.Time.now()
        self.goal.publish(message)

    def test_4_after_a_cancel_the_goal_that_comes_with_it_moves_nothing(self):
        for number, cancelled in enumerate(("moved-0", "")):  # by name, and all goals
            self.robot.start_fresh()
            self.send_goal("tense", f"moved-{number}")
            self.robot.wait(lambda: self.robot.speed() > 5e-3)
            self.cancel.publish(GoalID(id=cancelled))
            self.send_goal("release", f"late-{number}")
            self.robot.wait_for_state("halted", limit=5.0)
            self.robot.wait(lambda: self.robot.drift(0.1) < STILL)  # all is played out
            place = self.robot.joints.position
            rospy.sleep(1.0)
            self.assert_still(place)
            self.assertEqual(self.robot.state.state, "halted")
            self.assertEqual(self.outcome(f"moved-{number}"), "stopped")
            self.assertIn(self.outcome(f"late-{number}"), ("refused", "stopped"))

    def outcome(self, goal):
        self.robot.wait(lambda: goal in {r.status.goal_id.id for r in self.results})
        return next(r.result.outcome for r in self.results if r.status.goal_id.id == goal)

    def test_5_a_goal_and_its_cancel_at_once_leave_it_at_rest(self):
        self.robot.start_fresh()
        self.send_goal("tense", "brief")
        self.cancel.publish(GoalID(id="brief"))
        self.outcome("brief")
        self.robot.wait_for_state("halted", "active", limit=5.0)
        self.robot.wait_for_rest()

    def test_6_a_second_controller_does_not_start_and_the_first_goes_on(self):
        self.robot.start_fresh()
        self.robot.say("tense")
        done = subprocess.run(
            ["rosrun", "rst_control", "controller", "__name:=second_controller"],
            capture_output=True,
            text=True,
            timeout=PATIENCE,
            check=False,
        )
        self.assertEqual(done.returncode, 2)
        self.assertIn("/controller is one already", done.stdout + done.stderr)
        halts = len(self.robot.halts())
        self.robot.say("stop")
        self.robot.wait(lambda: len(self.robot.halts()) > halts)

    def test_7_a_cancel_that_names_no_goal_stops_a_motion_that_is_no_goal(self):
        self.robot.start_fresh()
        count = self.robot.finished("tense")
        self.robot.say("tense")
        self.robot.wait_for_motion()
        self.cancel.publish(GoalID())
        self.robot.wait_for_state("halted", limit=5.0)
        self.assertEqual(self.robot.state.halt_reason_code, "stop_cancel")
        self.robot.wait_for_rest()
        self.assertEqual(self.robot.finished("tense"), count)


if __name__ == "__main__":
    run_tests(Attacked, "attacked")

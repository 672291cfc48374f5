#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""All that was published while "tense" was carried out is played on the live master by a stranger.

It moves nothing, unlatches nothing and is named, whether it bears its own name or claims others'.
"""

import actionlib
import rosgraph
import rospy
from diagnostic_msgs.msg import DiagnosticArray
from sensor_msgs.msg import JointState

from rst_control.msg import AssistAction, AssistGoal
from tests.support.robot_client import RobotTest, run_tests
from tests.support.stranger import NAME, Copies, playing
from typed_config.ros.known_publishers import KnownPublishers

SYSTEM = {"/controller", "/robot"}
HALTS = {"/rst_control/stop", "/rst_control/execute/cancel"}  # count from anybody
PLAYED = 2.0  # [s]
KEPT = 40  # messages of each topic that are played, from all over the motion


def heard_topics():
    """Topics that a node of the system subscribes to, and that could move something."""
    _, subscribers, _ = rosgraph.Master(rospy.get_name()).getSystemState()
    return {topic for topic, nodes in subscribers if SYSTEM & set(nodes)} - HALTS - {"/clock"}


class PlayedBack(RobotTest):
    """The tests run in the order of their names and play what was recorded at the start."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.joints = None
        KnownPublishers().subscribe("joint_states", JointState, cls.take_joints, ["/robot"])
        cls.strangers = {}
        rospy.Subscriber("/diagnostics", DiagnosticArray, cls.take_diagnostics)
        client = actionlib.SimpleActionClient("rst_control/execute", AssistAction)
        assert client.wait_for_server(rospy.Duration(30))
        copies = Copies(heard_topics())
        goals = client.action_client.pub_goal
        cls.robot.wait(lambda: goals.get_num_connections() > 1)  # the controller's and the copies'
        cls.robot.start_fresh()
        for command in ("hey robot", "tense"):
            count = cls.robot.finished(command)
            client.send_goal(AssistGoal(command=command))
            cls.robot.wait(lambda c=command, n=count: c != "tense" or cls.robot.finished(c) > n)
        copies.close()
        of_topic = {}
        for place, message in enumerate(copies.messages):
            of_topic.setdefault(message[0], []).append(place)
        kept = [p for places in of_topic.values() for p in places[:: -(-len(places) // KEPT)]]
        cls.messages = [copies.messages[place] for place in sorted(kept)]
        cls.topics = set(of_topic)
        cls.robot.leave()
        cls.robot.wait(lambda: max(map(abs, cls.joints.velocity)) < 1e-4)

    @classmethod
    def take_joints(cls, message):
        cls.joints = message

    @classmethod
    def take_diagnostics(cls, array):
        for status in array.status:
            if status.name.endswith(": strangers"):
                cls.strangers[status.hardware_id] = status.message

    def named(self):
        return " ".join(self.strangers.values())

    def unnamed(self):
        """Topics of which no stranger is named."""
        return [topic for topic in self.known if f"{topic} from " not in self.named()]

    def assert_it_moves_nothing(self, *ways, **options):
        """In none of the states, each of which something brings about."""
        before = self.joints.position
        with playing(self.messages, **options):
            try:
                self.robot.wait(lambda: not self.unnamed())
            except AssertionError as error:
                raise AssertionError(f"{self.unnamed()}: {error}") from None
            for state, bring_about in ways:
                bring_about()
                rospy.sleep(PLAYED)
                self.assertEqual(self.robot.state.state, state, self.robot.state.halt_reason)
                now = self.joints.position
                drift = max(abs(a - b) for a, b in zip(before, now, strict=True))
                self.assertLess(drift, 1e-4)
        self.robot.wait(lambda: "from " not in self.named())

    @property
    def known(self):
        """Topics whose strangers are named; goals are turned away one by one, frames are not."""
        return self.topics - {"/rst_control/execute/goal", "/tf", "/tf_static"}

    def test_1_every_kind_of_message_was_recorded(self):
        wanted = {"/joint_states", "/robot/servo_jp", "/robot/gripped", "/robot/tension"}
        self.assertLessEqual(wanted | {"/rst_control/execute/goal"}, self.topics)

    def test_2_it_is_named_and_moves_nothing_in_standby_latched_or_active(self):
        stop = ("halted", self.stop)  # which stays
        self.assert_it_moves_nothing(
            ("standby", lambda: None), ("active", self.robot.activate), stop
        )
        self.assertIn("no strangers", self.strangers["controller"])

    def test_3_nor_does_it_under_the_names_of_others(self):
        self.assert_it_moves_nothing(("active", self.robot.activate), claim=True)

    def stop(self):
        self.robot.say("stop")
        self.robot.wait_for_state("halted")

    def test_4_a_motion_meanwhile_ends_where_it_should(self):
        self.robot.start_fresh()
        with playing(self.messages):
            self.robot.wait(lambda: NAME in self.named())
            self.robot.say_and_finish("tense")
            self.assertTrue(self.robot.state.tissue_held)
            self.robot.say_and_finish("release")


if __name__ == "__main__":
    run_tests(PlayedBack, "played_back")

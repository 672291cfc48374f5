#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The grasp point set at the site: in another frame, by a tracker, and by the tip's place."""

import numpy as np
import rospy
from geometry_msgs.msg import Point, PointStamped, TransformStamped, Vector3
from tf2_msgs.msg import TFMessage

from rst_control.srv import SetGraspPoint
from tests.support.robot_client import RobotTest, run_tests

CAMERA = np.array([0.3, 0.1, 0.9])  # [m] of a camera that looks straight down, x along the base's
ASIDE = 0.008  # [m] along the tissue's edge, to the next node


class GraspPointService(RobotTest):
    """The tests run in the order of their names and build on one robot."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.heard = []
        cls.topic = rospy.Subscriber("rst_control/grasp_point", PointStamped, cls.heard.append)
        rospy.wait_for_service("rst_control/set_grasp_point", 60.0)
        cls.service = rospy.ServiceProxy("rst_control/set_grasp_point", SetGraspPoint)
        cls.robot.wait(lambda: cls.heard)
        cls.first = cls.published()
        cls.frames = rospy.Publisher("/tf_static", TFMessage, queue_size=1, latch=True)
        joint = TransformStamped(child_frame_id="site_camera")
        joint.header.frame_id = "base_link"
        t, r = joint.transform.translation, joint.transform.rotation
        t.x, t.y, t.z = CAMERA
        r.x = 1.0  # half a turn about x
        cls.frames.publish(TFMessage([joint]))

    @classmethod
    def tearDownClass(cls):
        cls.robot.start_fresh()
        assert cls.service(position=Point(*cls.first)).accepted
        super().tearDownClass()

    @classmethod
    def published(cls):
        p = cls.heard[-1].point
        return np.array([p.x, p.y, p.z])

    @staticmethod
    def seen_by_camera(place):
        x, y, z = place - CAMERA
        return x, -y, -z

    def wait_for(self, place):
        self.robot.wait(lambda: np.allclose(self.published(), place, atol=1e-6))

    def test_1_in_another_frame_with_the_way_of_the_pull(self):
        place = self.first + np.array([ASIDE, 0.0, 0.0])
        given = {"position": Point(*self.seen_by_camera(place)), "frame": "site_camera"}
        given["pull_direction"] = Vector3(0.0, 0.0, -1.0)
        self.robot.wait(lambda: self.service(**given).reason_code != "unknown_frame", every=0.2)
        reply = self.service(**given)
        self.assertTrue(reply.accepted, reply.message)
        self.assertIn("pulled along (0.000, 0.000, 1.000)", reply.message)
        self.wait_for(place)
        state = self.robot.state
        self.robot.wait(lambda: self.robot.state.grasp_point_source == rospy.get_name())
        self.assertGreaterEqual(self.robot.state.grasp_point_age, 0.0)
        self.assertEqual(state.trocar_source, self.robot.state.trocar_source)

    def test_2_an_unknown_frame_is_refused_by_name(self):
        reply = self.service(position=Point(*self.first), frame="no_such_frame")
        self.assertEqual((reply.accepted, reply.reason_code), (False, "unknown_frame"))
        self.assertIn("no_such_frame", reply.message)

    def test_3_a_tracker_sets_it_once_it_is_steady(self):
        topic = rospy.Publisher("rst_control/tracker/grasp_point", PointStamped, queue_size=1)
        message = PointStamped(point=Point(*self.seen_by_camera(self.first)))
        message.header.frame_id = "site_camera"

        def is_set():
            message.header.stamp = rospy.Time.now()
            topic.publish(message)
            return np.allclose(self.published(), self.first, atol=1e-6)

        self.robot.wait(is_set, every=0.05)
        self.robot.wait(lambda: self.robot.state.grasp_point_source == rospy.get_name())
        topic.unregister()

    def test_4_the_tip_does_not_show_it_where_no_tissue_is(self):
        self.robot.start_fresh()
        reply = self.robot.command("grasp here")
        self.assertFalse(reply.accepted, reply.message)
        self.assertEqual(reply.reason_code, "no_grasp")
        np.testing.assert_allclose(self.published(), self.first, atol=1e-9)


if __name__ == "__main__":
    run_tests(GraspPointService, "grasp_point_service")

#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""A subscriber that misses the master's notice of a publisher gets it from master_failover."""

import threading
import time
import unittest
from xmlrpc.server import SimpleXMLRPCRequestHandler, SimpleXMLRPCServer

import rosgraph
import rospy
from std_msgs.msg import Bool

from support.waiting import wait_until
from tests.support.robot_client import run_tests

TOPIC = "/publishers_reported_again/news"


class Subscriber:
    """The API of a node, by hand: it notes each update of the publishers."""

    def __init__(self):
        self.updates = []
        self._server = SimpleXMLRPCServer(
            ("127.0.0.1", 0), SimpleXMLRPCRequestHandler, logRequests=False, allow_none=True
        )
        self._server.register_function(self._on_update, "publisherUpdate")
        threading.Thread(target=self._server.serve_forever, daemon=True).start()
        self.uri = f"http://127.0.0.1:{self._server.server_address[1]}/"

    def _on_update(self, _caller, topic, uris):
        if topic == TOPIC:
            self.updates.append(tuple(uris))
        return 1, "", 0


class PublishersReportedAgain(unittest.TestCase):
    def test_a_new_publisher_is_reported_three_times_in_all(self):
        subscriber, master = Subscriber(), rosgraph.Master("/by_hand")
        wait_until(lambda: "/master_failover" in registered(), "master_failover")
        master.registerSubscriber(TOPIC, "std_msgs/Bool", subscriber.uri)
        publisher = rospy.Publisher(TOPIC, Bool, queue_size=1)
        wait_until(lambda: subscriber.updates.count((rospy.get_node_uri(),)) >= 3, "three updates")
        time.sleep(2.0)
        self.assertEqual(subscriber.updates.count((rospy.get_node_uri(),)), 3)
        publisher.unregister()


def registered():
    publishers, _, _ = rosgraph.Master("/by_hand").getSystemState()
    return {node for _, nodes in publishers for node in nodes}


if __name__ == "__main__":
    run_tests(PublishersReportedAgain, "publishers_reported_again")

#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Every socket on which the system waits for peers is on loopback, as the kernel lists them."""

import socket
import unittest
from pathlib import Path
from xmlrpc.client import ServerProxy

import rosgraph
import rospy

from rst_control.host.listening_sockets import inodes_of, listeners, warnings
from tests.support.robot_client import RobotClient, run_tests

NODES = {"/controller", "/robot", "/voice_assist", "/recorder", "/robot_state_publisher"}
# Nodes in C++: the XML-RPC server of roscpp listens on every address, whatever ROS_IP says.
CPP = {"/rosout", "/robot_state_publisher"}
VOICE_LIMIT = 90.0  # [s] for the recogniser to be loaded


def children():
    """Numbers of the processes that each process started."""
    found = {}
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                parent = int((entry / "stat").read_text().rpartition(")")[2].split()[1])
            except OSError:  # it has ended
                continue
            found.setdefault(parent, []).append(int(entry.name))
    return found


def with_descendants(process, tree):
    """A process and all that it and its own started."""
    return [process, *(p for child in tree.get(process, ()) for p in with_descendants(child, tree))]


def parent_of(process, tree):
    return next(parent for parent, started in tree.items() if process in started)


class Loopback(unittest.TestCase):
    """The system runs; its sockets are looked up."""

    @classmethod
    def setUpClass(cls):
        cls.robot = RobotClient()
        cls.master = rosgraph.Master(rospy.get_name())
        cls.robot.wait(lambda: set(cls.nodes()) >= NODES, VOICE_LIMIT, every=0.2)

    @classmethod
    def nodes(cls):
        state = cls.master.getSystemState()
        return sorted({node for part in state for _, nodes in part for node in nodes})

    def processes(self):
        """Numbers of the system's processes by what they are."""
        me, tree = rospy.get_name(), children()
        uris = {name: self.master.lookupNode(name) for name in self.nodes() if name != me}
        roots = {name: ServerProxy(uri).getPid(me)[2] for name, uri in uris.items()}
        roots["master"] = self.master.getPid()
        found = {name: with_descendants(root, tree) for name, root in roots.items()}
        return {**found, "roslaunch": [parent_of(roots["/robot_state_publisher"], tree)]}

    def listening(self):
        """What each part of the system listens on."""
        found = listeners()
        for part, processes in self.processes().items():
            inodes = set().union(*(inodes_of(process) for process in processes))
            yield part, [one for one in found if one.inode in inodes]

    def test_every_part_listens_on_loopback_alone(self):
        parts = dict(self.listening())
        self.assertGreaterEqual(set(parts), NODES | {"master"})
        for part in NODES | {"master"}:
            self.assertTrue(parts[part], f"{part} was not found to listen on anything")
        open_to_all = [
            f"{part}: {one}"
            for part, found in parts.items()
            for one in found
            if not one.is_loopback and part not in CPP
        ]
        self.assertEqual(open_to_all, [])
        for part in CPP & set(parts):
            self.assertLessEqual(sum(not one.is_loopback for one in parts[part]), 1, part)
        self.assertEqual(warnings(rosgraph.get_master_uri(), listeners(), inodes_of()), [])

    def test_a_socket_that_is_open_to_all_would_be_found(self):
        with socket.socket() as opened:
            opened.bind(("0.0.0.0", 0))
            opened.listen()
            own = inodes_of()
            (words,) = warnings(rosgraph.get_master_uri(), listeners(), own)
            self.assertIn(str(opened.getsockname()[1]), words)


if __name__ == "__main__":
    run_tests(Loopback, "loopback")

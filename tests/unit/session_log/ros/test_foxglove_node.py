# SPDX-License-Identifier: BSD-3-Clause
"""The URDF for a viewer, while the ROS master is away, hangs, or has none."""

import socket
import sys
import threading
import time
from types import SimpleNamespace
from xmlrpc.server import SimpleXMLRPCServer

import pytest

from session_log.config import FoxgloveConfig
from session_log.recording.namespace import Namespace
from session_log.ros import foxglove_node
from session_log.types import URDF_TOPIC
from support.waiting import PATIENCE
from typed_config import load_file
from typed_config.ros import xmlrpc

URDF = "<robot/>"
ANSWER_TIME = PATIENCE  # [s] it is there, but maybe late
VIEWED = SimpleNamespace(topic=URDF_TOPIC)


class Channel:
    """What viewers of the only topic get."""

    def __init__(self, said):
        self.said = said

    def __call__(self, *_, **__):
        return self

    def log(self, data):
        self.said.append(data[4:].decode())


@pytest.fixture
def said():
    return []


@pytest.fixture
def topics(monkeypatch, said):
    """Those of a system whose master was there once."""
    sdk = SimpleNamespace(Channel=Channel(said), Schema=SimpleNamespace)
    monkeypatch.setitem(sys.modules, "foxglove", sdk)
    monkeypatch.setattr(foxglove_node, "AGAIN", 0.0)
    monkeypatch.setattr(xmlrpc, "ANSWER_TIME", ANSWER_TIME)
    topics = foxglove_node.LiveTopics(load_file(FoxgloveConfig, foxglove_node.FILE), Namespace("/"))
    with monkeypatch.context() as patch:
        patch.setattr(foxglove_node, "published_topics", list)
        topics.search()
    return topics


@pytest.fixture
def listener(monkeypatch):
    """The place of a master that takes connections and never answers."""
    monkeypatch.setattr(xmlrpc, "ANSWER_TIME", 0.02)  # after which it is given up
    with socket.create_server(("127.0.0.1", 0)) as listener:
        uri = f"http://127.0.0.1:{listener.getsockname()[1]}"
        monkeypatch.setenv("ROS_MASTER_URI", uri)
        yield listener


@pytest.fixture
def master(monkeypatch):
    """A master that has parameters and nothing else."""
    parameters = {}

    def get_param(caller, name):
        return (1, "", parameters[name]) if name in parameters else (-1, "not set", 0)

    with SimpleXMLRPCServer(("127.0.0.1", 0), logRequests=False) as server:
        server.register_function(get_param, "getParam")
        threading.Thread(target=server.serve_forever, args=(0.01,), daemon=True).start()
        monkeypatch.setenv("ROS_MASTER_URI", f"http://127.0.0.1:{server.server_address[1]}")
        yield parameters
        server.shutdown()


def test_a_viewer_gets_the_urdf(topics, said, master):
    master["/robot_description"] = URDF
    topics.on_subscribe(None, VIEWED)
    topics.follow(0.0)
    assert said and set(said) == {URDF}


@pytest.mark.parametrize("hangs", [False, True])
def test_without_an_answer_of_the_master_the_others_are_served_on(topics, said, listener, hangs):
    if not hangs:
        listener.close()
    topics.on_subscribe(None, VIEWED)
    failures = []

    def follow():
        try:
            topics.follow(0.0)
        except OSError as error:
            failures.append(error)

    following = threading.Thread(target=follow, daemon=True)
    following.start()
    following.join(PATIENCE)
    assert not following.is_alive()
    assert not failures and not said


def test_the_urdf_of_a_master_that_starts_again_comes_late(topics, said, master, monkeypatch):
    monkeypatch.setattr(foxglove_node, "AGAIN", 0.01)
    topics.on_subscribe(None, VIEWED)
    topics.follow(0.0)
    assert set(said) == {""}
    said.clear()
    master["/robot_description"] = URDF
    time.sleep(0.02)
    topics.follow(0.0)
    assert said and set(said) == {URDF}


def test_it_is_not_asked_for_when_nobody_views_it(topics, said, master, monkeypatch):
    monkeypatch.setattr(foxglove_node, "AGAIN", 0.01)
    topics.on_subscribe(None, VIEWED)
    topics.follow(0.0)
    topics.on_unsubscribe(None, VIEWED)
    master["/robot_description"] = URDF
    time.sleep(0.02)
    topics.follow(0.0)
    assert URDF not in said

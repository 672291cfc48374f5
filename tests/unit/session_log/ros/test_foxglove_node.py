# SPDX-License-Identifier: BSD-3-Clause
"""What is served; the URDF for a viewer, while the ROS master is away, hangs, or has none."""

import socket
import sys
import threading
import time
from types import SimpleNamespace
from xmlrpc.server import SimpleXMLRPCServer

import pytest
import rospy

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


STATIC = "/tf_static"
SOUND = (
    "voice_assist/AudioChunk",
    "audio_common_msgs/AudioData",
    "audio_common_msgs/AudioDataStamped",
)


class Channel:
    """What viewers of any topic get."""

    def __init__(self, said):
        self.said, self.topics = said, []

    def __call__(self, topic, **_):
        self.topics.append(topic)
        return self

    def log(self, data):
        self.said.append(data[4:].decode())


@pytest.fixture
def said():
    return []


class Subscriber:
    """A subscriber of two nodes."""

    def __init__(self, name, kind, callback, **_):
        self.receive, self.impl = callback, SimpleNamespace()
        self.open("/robot", "/trocar")

    def get_num_connections(self):
        return len(self.impl.connections)

    def open(self, *publishers):
        """Have connections from these alone."""
        is_open = {"done": False, "socket": "open"}
        self.impl.connections = [SimpleNamespace(callerid_pub=p, **is_open) for p in publishers]

    def latch(self, publisher, text):
        """Receive a latched message."""
        header = {"latching": "1", "callerid": publisher}
        data = bytes(4) + text.encode()
        message = rospy.AnyMsg()
        message._connection_header, message._buff = header, data
        self.receive(message)


@pytest.fixture
def channel(said):
    return Channel(said)


@pytest.fixture
def topics(monkeypatch, channel):
    """Those of a system whose master was there once."""
    sdk = SimpleNamespace(Channel=channel, Schema=SimpleNamespace)
    monkeypatch.setitem(sys.modules, "foxglove", sdk)
    monkeypatch.setattr(foxglove_node, "AGAIN", 0.0)
    monkeypatch.setattr(xmlrpc, "ANSWER_TIME", ANSWER_TIME)
    topics = foxglove_node.LiveTopics(load_file(FoxgloveConfig, foxglove_node.FILE), Namespace("/"))
    with monkeypatch.context() as patch:
        patch.setattr(foxglove_node, "published_topics", list)
        topics.search()
    return topics


@pytest.fixture
def offer(topics, monkeypatch):
    """Offers what of these topics may be served."""

    def built(kind):
        return SimpleNamespace(_type=kind, _full_text="")

    def search(published):
        monkeypatch.setattr(foxglove_node, "published_topics", lambda: published)
        monkeypatch.setattr(foxglove_node.roslib.message, "get_message_class", built)
        topics.search()

    return search


@pytest.fixture
def view(topics, offer, said, monkeypatch):
    """Has one more viewer of the static frames; gives the subscriber and what that viewer gets."""
    monkeypatch.setattr(foxglove_node.rospy, "Subscriber", Subscriber)
    offer([(STATIC, "tf2_msgs/TFMessage")])

    def come():
        said.clear()
        topics.on_subscribe(None, SimpleNamespace(topic=STATIC))
        topics.follow(0.0)
        return topics._subscribers[STATIC], list(dict.fromkeys(said))

    return come


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


@pytest.mark.parametrize("kind", SOUND)
@pytest.mark.parametrize("name", ["/audio_in", "/played/voice_assist/audio", "/left/sound"])
def test_sound_is_not_served_whatever_its_topic(offer, channel, name, kind):
    offer([(name, kind), ("/audio/audio_info", "audio_common_msgs/AudioInfo")])
    assert channel.topics == [URDF_TOPIC, "/audio/audio_info"]


def test_a_later_viewer_gets_the_latched_message_of_each_publisher(view):
    frames, _ = view()
    for publisher, text in (("/robot", "old"), ("/trocar", "trocar"), ("/robot", "robot")):
        frames.latch(publisher, text)
    assert view() == (frames, ["trocar", "robot"])  # in order of time


def test_a_later_viewer_gets_nothing_of_a_publisher_that_has_gone(view):
    frames, _ = view()
    frames.latch("/robot", "robot")
    frames.latch("/trocar", "trocar")
    frames.open("/trocar")
    assert view() == (frames, ["trocar"])


def test_a_topic_whose_type_nobody_knows_hides_no_other_and_is_offered_once_it_has_one(
    topics, channel, monkeypatch
):
    """A relay offers messages of any type, until it hears the first."""
    known = [("/relay", "*"), ("/odd", "odd"), ("/a", "std_msgs/String")]
    monkeypatch.setattr(foxglove_node, "published_topics", lambda: known)
    topics.search()
    assert channel.topics[-1] == "/a" and "/relay" not in channel.topics
    known[0] = ("/relay", "std_msgs/String")
    topics.search()
    assert channel.topics[-1] == "/relay" and "/odd" not in channel.topics

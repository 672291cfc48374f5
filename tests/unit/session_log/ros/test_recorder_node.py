# SPDX-License-Identifier: BSD-3-Clause
"""How the recorder node ends."""

import threading
from io import BytesIO
from types import SimpleNamespace
from unittest.mock import MagicMock

import pytest
import rospy
from rosgraph_msgs.msg import Clock

from session_log.recording.namespace import Namespace
from session_log.ros import discovery, recorder_node
from support.waiting import PATIENCE, wait_until


@pytest.fixture
def recorder(monkeypatch, recorder_config):
    """What the node records with; the node ends as soon as it was started."""
    at_end = []
    rospy = MagicMock(on_shutdown=at_end.append, spin=lambda: at_end[0]())
    rospy.get_namespace.return_value = "/"
    monkeypatch.setattr(recorder_node, "rospy", rospy)
    recorder = MagicMock()
    recorder.close.return_value = ""
    recorder.status.return_value = SimpleNamespace(written=7, path="/session.mcap")
    monkeypatch.setattr(recorder_node, "Recorder", lambda *_: recorder)
    parts = ("TopicSubscriber", "Discovery", "RecorderDiagnostics", "Announcer")
    for name in (*parts, "ParameterWatcher", "add_facts", "starting"):
        monkeypatch.setattr(recorder_node, name, MagicMock())
    monkeypatch.setattr(recorder_node, "load_config", lambda *_: recorder_config)
    monkeypatch.setattr(recorder_node.RecorderNode, "_run_turns", lambda node: None)
    return recorder


@pytest.mark.parametrize(("error", "status"), [("", 0), ("the disk is full", 1)])
def test_a_recording_that_is_not_complete_is_no_success(recorder, error, status):
    recorder.close.return_value = error
    with pytest.raises(SystemExit) as end:
        recorder_node.main()
    assert end.value.code == status


def test_the_file_is_closed_though_the_master_takes_no_subscriber_off(
    recorder, monkeypatch, capsys
):
    is_over = threading.Event()
    hanging = SimpleNamespace(unregister=lambda: is_over.wait(PATIENCE))
    monkeypatch.setattr(discovery.rospy, "Subscriber", lambda *_, **__: hanging)
    monkeypatch.setattr(recorder_node, "TopicSubscriber", discovery.TopicSubscriber)
    ended = []

    def run():
        with pytest.raises(SystemExit) as end:
            recorder_node.main()
        ended.append(end.value.code)

    threading.Thread(target=run, daemon=True).start()
    try:
        wait_until(lambda: ended, "the end of the node")
    finally:
        is_over.set()
    assert ended == [0] and recorder.close.called
    assert capsys.readouterr().out == "session_log: 7 messages in /session.mcap\n"


def test_what_comes_after_the_end_is_not_offered_to_the_recorder(monkeypatch):
    taken, recorder = [], MagicMock()

    def subscribe(name, kind, take, **_):
        taken.append(take)

    monkeypatch.setattr(discovery.rospy, "Subscriber", subscribe)
    topics = discovery.TopicSubscriber(recorder, Namespace("/"), ())
    topics.subscribe("/joint_states")
    header = {"type": "std_msgs/Empty", "callerid": "/robot"}
    message = rospy.AnyMsg()
    message._connection_header, message._buff = header, b""
    for _ in range(2):
        taken[0](message)
        topics.close()
    assert recorder.offer.call_count == 1


def test_a_topic_that_rospy_itself_reads_is_recorded_as_it_came(monkeypatch):
    """Its subscriber has the class of the message, which then comes to all of them."""
    taken, recorder = [], MagicMock()
    monkeypatch.setattr(
        discovery.rospy, "Subscriber", lambda name, kind, take, **_: taken.append(take)
    )
    discovery.TopicSubscriber(recorder, Namespace("/"), ()).subscribe("/clock")
    message, buffer = Clock(rospy.Time(5, 7)), BytesIO()
    message.serialize(buffer)
    message._connection_header = {"type": "rosgraph_msgs/Clock", "callerid": "/robot"}
    taken[0](message)
    (_, data), _ = recorder.offer.call_args
    assert data == buffer.getvalue()

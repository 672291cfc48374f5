# SPDX-License-Identifier: BSD-3-Clause
"""The player before it meets ROS: what keeps it from playing is one line, at once."""

import sys
from dataclasses import replace
from pathlib import Path

import pytest

from session_log.mcap_file.condition import FileCondition
from session_log.mcap_file.encoding import WrongEncoding
from session_log.mcap_file.reader import SessionReader
from session_log.ros import player_node
from session_log.types import Message, MessageSource
from support.message_classes import class_of, source_of
from support.story import Story, recording_of
from tests.unit.session_log.support.foreign import NOW, write_foreign


@pytest.mark.parametrize("is_there", [False, True])
def test_without_file_or_master_it_ends_with_one_line(monkeypatch, tmp_path, is_there):
    path = recording_of(tmp_path / "s.mcap").path if is_there else tmp_path / "none.mcap"
    monkeypatch.setattr(sys, "argv", ["play", str(path)])
    monkeypatch.setenv("ROS_MASTER_URI", "http://127.0.0.1:1")
    monkeypatch.setattr(player_node.rospy, "init_node", lambda *_, **__: pytest.fail("waits"))
    with pytest.raises(SystemExit) as end:
        player_node.main()
    reason = "no ROS master at http://127.0.0.1:1" if is_there else "none.mcap: no such file"
    assert reason in str(end.value) and "\n" not in str(end.value)


@pytest.mark.parametrize("uri", ["localhost:11311", "http://127.0.0.1:99999", ""])
def test_a_master_uri_that_is_no_address_is_named(monkeypatch, tmp_path, uri):
    monkeypatch.setattr(sys, "argv", ["play", str(recording_of(tmp_path / "s.mcap").path)])
    monkeypatch.setenv("ROS_MASTER_URI", uri)
    with pytest.raises(SystemExit) as end:
        player_node.main()
    assert (
        str(end.value) == f"no ROS master at {uri!r}: ROS_MASTER_URI has the form http://HOST:PORT"
    )


SECOND = 10**9  # [ns]


def player_of(path, seconds):
    """A player of a recording with a message at each time after now [s]."""
    source = MessageSource("/t", "std_msgs/String", "99" * 16, "string data", "/p")
    times = enumerate((NOW + round(s * SECOND) for s in seconds), 1)
    session = recording_of(path, [Message(source, b"x", t, k) for k, t in times])
    return player_node.RecordingPlayer(session, 1.0, "/played", pytest.fail)


@pytest.fixture
def waits(monkeypatch):
    """Waits of the player [s]; its clock runs only in them."""
    waits = []
    monkeypatch.setattr(player_node.time, "sleep", waits.append)
    monkeypatch.setattr(player_node.time, "monotonic", lambda: sum(waits))
    return waits


def test_ctrl_c_ends_a_long_pause_of_the_recording(monkeypatch, tmp_path, waits):
    """rospy takes Ctrl-C as a request to shut down, and Python's sleep goes on after a signal."""
    asked = iter([False] * 3)
    monkeypatch.setattr(player_node.rospy, "is_shutdown", lambda: next(asked, True))
    player_of(tmp_path / "s.mcap", (0.0, 9.0)).play()
    assert waits and max(waits) <= player_node.LONGEST_SLEEP and sum(waits) < 1.0


@pytest.mark.parametrize(
    ("seconds", "duration", "words"),
    [
        ((0.0, 1.0, 3601.0, 3602.0), 2.0, "the clock was set forward by 3600.0 s at "),
        ((0.0, 1.0, -59.0, -58.0), 2.0, "the clock was set back by 60.0 s at "),
        ((0.0, 9.0), 9.0, ""),
        ((0.0, 1.0, 0.95, 2.0), 2.0, ""),
    ],
    ids=["forward", "back", "a pause", "a little out of order"],
)
def test_where_the_clock_was_set_the_pace_begins_anew(
    monkeypatch, tmp_path, waits, capsys, seconds, duration, words
):
    monkeypatch.setattr(player_node.rospy, "is_shutdown", lambda: False)
    player_of(tmp_path / "s.mcap", seconds).play()
    said = capsys.readouterr().out
    assert sum(waits) == pytest.approx(duration, abs=0.01)
    assert said.count("\n") == bool(words) and said.startswith(words)


def test_the_order_of_other_programs_files_is_none_of_a_clock(monkeypatch, tmp_path, waits, capsys):
    monkeypatch.setattr(player_node.rospy, "is_shutdown", lambda: False)
    monkeypatch.setattr(FileCondition, "is_numbered", False)
    player_of(tmp_path / "s.mcap", (0.0, 60.0, 59.0, 61.0)).play()
    assert sum(waits) == pytest.approx(61.0, abs=0.01)
    assert not capsys.readouterr().out


class Topic:
    """Stands in for a publisher, and keeps what it is given."""

    def __init__(self, name, kind, **_):
        self.name, self.data_class, self.sent = name, kind, []

    def publish(self, message):
        self.sent.append(message._buff)


def test_a_viewer_that_comes_late_gets_the_static_frames_of_every_node(
    monkeypatch, tmp_path, waits
):
    """A topic that is played has one publisher, which keeps its last message for them."""
    monkeypatch.setattr(player_node.rospy, "is_shutdown", lambda: False)
    monkeypatch.setattr(player_node.rospy, "Publisher", Topic)
    messages, frame = [], class_of("geometry_msgs/TransformStamped")
    for node in ("trocar", "camera"):
        story = Story()
        story.sources["/tf_static"] = source_of("/tf_static", "tf2_msgs/TFMessage", f"/{node}")
        frames = [frame(child_frame_id=node)]
        story.say(1.0, "/tf_static", "tf2_msgs/TFMessage", transforms=frames)
        messages += story.messages
    odd = messages[0]._replace(data=b"x", sequence=2)
    session = recording_of(tmp_path / "s.mcap", [*messages, odd])
    player = player_node.RecordingPlayer(session, 1.0, "/played", pytest.fail)
    player.prepare()
    player.play()
    (topic,) = player._out.values()
    last = class_of("tf2_msgs/TFMessage")().deserialize(topic.sent[1])
    assert [f.child_frame_id for f in last.transforms] == ["trocar", "camera"]
    assert (topic.sent[0], topic.sent[2]) == (messages[0].data, b"x")


def text_then(path, rest):
    """A player of a recording of /x: a text, then the rest."""
    text = source_of("/x", "std_msgs/String")
    messages = [Message(text, b"\1\0\0\0a", NOW, 1), *rest]
    session = recording_of(path, messages)
    return player_node.RecordingPlayer(session, 1.0, "/played", pytest.fail)


def test_of_a_topic_of_two_types_only_the_last_is_played_and_it_is_said(
    monkeypatch, tmp_path, waits, capsys
):
    """The bytes of a text would be taken for a number."""
    monkeypatch.setattr(player_node.rospy, "is_shutdown", lambda: False)
    monkeypatch.setattr(player_node.rospy, "Publisher", Topic)
    number = Message(source_of("/x", "std_msgs/Int32"), b"\7\0\0\0", NOW + 1, 1)
    player = text_then(tmp_path / "s.mcap", [number])
    player.prepare()
    player.play()
    (topic,) = player._out.values()
    assert (topic.sent, player.count) == ([number.data], 1)
    assert topic.data_class._type == "std_msgs/Int32"
    said = capsys.readouterr().out
    assert said == "1 messages of /x of another type are not played\n"


def test_messages_of_one_type_by_two_nodes_are_all_played(monkeypatch, tmp_path, waits, capsys):
    monkeypatch.setattr(player_node.rospy, "is_shutdown", lambda: False)
    monkeypatch.setattr(player_node.rospy, "Publisher", Topic)
    other = Message(source_of("/x", "std_msgs/String", "/other"), b"\1\0\0\0b", NOW + 1, 1)
    player = text_then(tmp_path / "s.mcap", [other])
    player.prepare()
    player.play()
    (topic,) = player._out.values()
    assert topic.sent == [b"\1\0\0\0a", b"\1\0\0\0b"] and not capsys.readouterr().out


def test_a_topic_whose_first_messages_are_none_of_ros_1_is_refused(monkeypatch, tmp_path):
    monkeypatch.setattr(player_node.rospy, "Publisher", Topic)
    sound = source_of("/x", "std_msgs/String")
    foreign = replace(sound, message_encoding="cdr", schema_encoding="ros2msg")
    messages = [Message(s, b"\1\0\0\0a", NOW + k, 1) for k, s in enumerate((foreign, sound))]
    session = recording_of(tmp_path / "s.mcap")
    monkeypatch.setattr(session, "messages", lambda: iter(messages))
    player = player_node.RecordingPlayer(session, 1.0, "/played", pytest.fail)
    with pytest.raises(WrongEncoding, match="/x: recorded as 'cdr'"):
        player.prepare()


def test_messages_that_are_none_of_ros_1_are_not_played(tmp_path):
    session = SessionReader(write_foreign(tmp_path / "s.mcap"))
    player = player_node.RecordingPlayer(session, 1.0, "/played", pytest.fail)
    with pytest.raises(WrongEncoding, match="/t: recorded as 'cdr'"):
        player.prepare()


def test_a_folder_that_may_not_be_read_is_one_line(monkeypatch, tmp_path):
    def refuse(path):
        raise PermissionError(13, "Permission denied", str(path))

    monkeypatch.setattr(sys, "argv", ["play", str(tmp_path)])
    monkeypatch.setattr(Path, "iterdir", refuse)
    with pytest.raises(SystemExit) as end:
        player_node.main()
    assert str(end.value) == f"{tmp_path}: Permission denied"


@pytest.mark.parametrize("is_whole", [True, False])
def test_before_it_plays_a_recording_it_says_what_is_wrong_with_it(
    monkeypatch, tmp_path, capsys, is_whole
):
    path = recording_of(tmp_path / "s.mcap").path
    if not is_whole:
        path.write_bytes(path.read_bytes()[:-20])
    monkeypatch.setattr(sys, "argv", ["play", str(path)])
    monkeypatch.setattr(player_node, "check_master", lambda: None)
    for name in ("init_node", "Publisher", "set_param"):
        monkeypatch.setattr(player_node.rospy, name, lambda *_, **__: None)
    monkeypatch.setattr(player_node.rospy, "is_shutdown", lambda: True)
    player_node.main()
    said = capsys.readouterr().out.splitlines()
    assert [line.partition(":")[0].partition(" at ")[0] for line in said] == [
        *([] if is_whole else ["not closed", "lost 17 bytes"]),
        "0 messages played",
    ]

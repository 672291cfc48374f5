# SPDX-License-Identifier: BSD-3-Clause
import pytest
from mcap.reader import make_reader

from session_log.errors import OutputFailed
from session_log.mcap_file.condition import FileCondition
from session_log.mcap_file.encoding import WrongEncoding
from session_log.mcap_file.reader import SessionReader
from session_log.mcap_file.recover import recover
from session_log.mcap_file.summary import RecordingSummary, read_summary
from session_log.types import Message, MessageSource
from support.story import recording_of
from tests.unit.session_log.support.foreign import EARLIER, NOW, write_foreign
from tests.unit.session_log.support.unchunked import UnchunkedWriter

ROS_1 = {"message_encoding": "ros1", "schema_encoding": "ros1msg"}


def test_a_killed_recording_becomes_a_sound_indexed_file(story, tmp_path):
    path, messages = story
    content = path.read_bytes()
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(content[: len(content) // 2])
    with cut.open("rb") as file, pytest.raises(Exception, match=r".*"):
        list(make_reader(file).iter_messages())
    result = recover(SessionReader(cut), tmp_path / "new.mcap")
    found = list(SessionReader(tmp_path / "new.mcap").messages())
    assert found == messages[: len(found)] and len(found) == result.messages > 1000
    with (tmp_path / "new.mcap").open("rb") as file:
        summary = make_reader(file, validate_crcs=True).get_summary()
    assert summary.statistics.message_count == len(found) and summary.chunk_indexes


def test_the_copy_says_what_it_was_made_from(story, tmp_path):
    path, _ = story
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(path.read_bytes()[:-5000])
    recover(SessionReader(cut), tmp_path / "new.mcap")
    condition = read_summary(SessionReader(tmp_path / "new.mcap")).condition
    account = condition.latest("recovered")
    assert account["from"] == "cut.mcap" and account["was_closed"] == "False"
    assert condition.latest("session")["seed"] == "7"


def test_an_existing_copy_is_not_overwritten(story, tmp_path):
    (tmp_path / "new.mcap").write_bytes(b"precious")
    with pytest.raises(OutputFailed, match="File exists"):
        recover(SessionReader(story[0]), tmp_path / "new.mcap")
    assert (tmp_path / "new.mcap").read_bytes() == b"precious"


def test_half_a_copy_is_not_kept(story, tmp_path, monkeypatch):
    """It would be closed and sound, and stand in the way of the next attempt."""
    reader, target = SessionReader(story[0]), tmp_path / "new.mcap"

    def interrupted():
        yield next(whole)
        raise KeyboardInterrupt

    whole = reader.messages()
    with monkeypatch.context() as once:
        once.setattr(reader, "messages", interrupted)
        with pytest.raises(KeyboardInterrupt):
            recover(reader, target)
    assert not target.exists()
    assert recover(reader, target).messages == len(story[1])


@pytest.mark.parametrize(
    ("encoding", "schema"), [("cdr", "ros2msg"), ("json", "jsonschema"), ("ros1", "protobuf")]
)
def test_messages_that_are_none_of_ros_1_are_refused_and_left_alone(tmp_path, encoding, schema):
    path = write_foreign(tmp_path / "s.mcap", message_encoding=encoding, schema_encoding=schema)
    before = path.read_bytes()
    words = f"/t: recorded as '{encoding}' with schema '{schema}', only 'ros1' with 'ros1msg' is"
    with pytest.raises(WrongEncoding, match=words):
        recover(SessionReader(path), tmp_path / "new.mcap")
    assert path.read_bytes() == before and list(tmp_path.iterdir()) == [path]


def test_a_copy_keeps_the_time_of_publishing(tmp_path):
    path = write_foreign(tmp_path / "s.mcap", **ROS_1)
    assert recover(SessionReader(path), tmp_path / "new.mcap").messages == 1
    with (tmp_path / "new.mcap").open("rb") as file:
        ((_, _, message),) = make_reader(file).iter_messages()
    assert (message.publish_time, message.log_time) == (NOW - EARLIER, NOW)


SIMULATED = [k * 10**9 for k in range(5)]  # [ns]
UNORDERED = [NOW + k * 10**9 for k in (3, 4, 0, 1, 2)]  # [ns]


@pytest.mark.parametrize(
    "made",
    [
        {},
        {"times": UNORDERED},
        {"times": SIMULATED, "use_chunking": False},
        {"times": UNORDERED, "chunk_size": 1, "use_statistics": False, "repeat_channels": False},
        {"private": (0x81, b"its own"), "use_chunking": False},
        {"private": (0x80, b"its own"), "use_chunking": False},
        {"private": (0x80, b"like a check"), "use_chunking": False},
    ],
    ids=lambda made: "-".join(made) or "numbers",
)
def test_nothing_is_said_to_be_lost_of_a_sound_file_of_another_writer(tmp_path, made):
    path = write_foreign(tmp_path / "s.mcap", ("/a", "/b"), **ROS_1, **made)
    count = 2 * len(made.get("times", [NOW]))
    source = path
    for name in ("copy.mcap", "copy of a copy.mcap"):
        recover(SessionReader(source), tmp_path / name)
        for read in (read_summary(SessionReader(p)) for p in (source, tmp_path / name)):
            assert read.messages == count and not read.condition.damage
            assert (read.missing, read.clock_steps, read.cuts) == (0, [], [])
        source = tmp_path / name
    before, after = list(SessionReader(path).messages()), list(SessionReader(source).messages())
    assert [m[1:] for m in after] == [m[1:] for m in before]


def test_what_a_damaged_file_of_another_writer_lost_is_said(tmp_path):
    options = {"times": UNORDERED, "chunk_size": 1}
    path = write_foreign(tmp_path / "s.mcap", **ROS_1, **options)
    content = bytearray(path.read_bytes())
    content[content.index(b"/t") + 400] ^= 0xFF
    path.write_bytes(content)
    assert recover(SessionReader(path), tmp_path / "new.mcap").condition.damage
    assert read_summary(SessionReader(tmp_path / "new.mcap")).cuts


def test_a_copy_of_a_recording_of_ours_still_says_what_is_missing(tmp_path):
    source = MessageSource("/t", "std_msgs/String", "99" * 16, "string data", "/p")
    path = tmp_path / "s.mcap"
    recording_of(path, [Message(source, b"\0\0\0\0", NOW + k, k) for k in (1, 4)])
    assert recover(SessionReader(path), tmp_path / "new.mcap").missing == 2
    assert read_summary(SessionReader(tmp_path / "new.mcap")).missing == 2


def test_a_damaged_encoding_in_a_file_of_ours_is_no_other_encoding(tmp_path):
    path = tmp_path / "s.mcap"
    source = MessageSource("/t", "std_msgs/String", "99" * 16, "string data", "/p")
    writer = UnchunkedWriter(path)
    writer.add(Message(source, b"\0\0\0\0", NOW, 1))
    writer.commit()
    writer.abandon()
    encoding = b"\4\0\0\0ros1"
    content = path.read_bytes()
    assert content.count(b"/t" + encoding) == 1
    path.write_bytes(content.replace(b"/t" + encoding, b"/t" + encoding[:-1] + b"9"))
    assert recover(SessionReader(path), tmp_path / "new.mcap").condition.damage


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({}, []),
        ({"checksum": "good"}, []),
        ({"checksum": "wrong"}, ["copied from a.mcap, which had a wrong checksum"]),
        ({"was_closed": "False"}, ["copied from a.mcap, which was not closed"]),
        ({"unreadable_bytes": "9"}, ["copied from a.mcap, which lost 9 bytes"]),
        (
            {"was_closed": "False", "unreadable_bytes": "9"},
            ["copied from a.mcap, which was not closed and lost 9 bytes"],
        ),
    ],
)
def test_a_copy_is_judged_by_its_account(changes, words):
    account = {"from": "a.mcap", "was_closed": "True", "unreadable_bytes": "0", "damage": ""}
    condition = FileCondition(metadata=[("recovered", {**account, **changes})])
    assert RecordingSummary(condition).cuts == words


def test_a_copy_says_that_its_original_had_a_wrong_checksum(tmp_path):
    options = {"use_chunking": False, "enable_data_crcs": True}
    path = write_foreign(tmp_path / "s.mcap", **ROS_1, **options)
    content = path.read_bytes()
    path.write_bytes(content.replace(b"\1\0\0\0x", b"\1\0\0\0y"))
    assert recover(SessionReader(path), tmp_path / "new.mcap").condition.checksum == "wrong"
    words = "copied from s.mcap, which had a wrong checksum"
    assert read_summary(SessionReader(tmp_path / "new.mcap")).cuts == [words]

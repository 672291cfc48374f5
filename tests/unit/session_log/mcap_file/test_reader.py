# SPDX-License-Identifier: BSD-3-Clause
"""Reading what a crash, a bad disk or a careless copy left."""

import random
import tracemalloc

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from session_log.errors import NotASession, SessionMissing
from session_log.mcap_file.reader import SessionReader
from session_log.mcap_file.records import CHECKSUM_BODY, HEAD
from session_log.mcap_file.summary import read_summary
from session_log.mcap_file.writer import SessionWriter
from session_log.types import Message, MessageSource
from tests.unit.session_log.support.broken_disk import break_reading
from tests.unit.session_log.support.unchunked import UnchunkedWriter

NOW = 1_795_200_000_000_000_000
SOURCES = [
    MessageSource(f"/t{i}", "std_msgs/String", "992c", "string data", "/p") for i in range(3)
]
COUNT = 60
CHECKSUM = HEAD.size + CHECKSUM_BODY.size  # [B]


def message(k):
    source = SOURCES[k % 3]
    text = bytes(random.Random(k).randbytes(20 + k))
    return Message(source, len(text).to_bytes(4, "little") + text, NOW + k * 10**6, k // 3 + 1)


def write(path, *, chunked=False, count=COUNT):
    writer = (SessionWriter if chunked else UnchunkedWriter)(path)
    writer.add_metadata("session", {"seed": "7"})
    ends = []
    for k in range(count):
        writer.add(message(k))
        writer.commit()
        ends.append(writer.committed)
    writer.close()
    return ends


def written(path, **options):
    ends = write(path, **options)
    return path.read_bytes(), ends


@pytest.fixture(scope="module")
def sound(tmp_path_factory):
    return written(tmp_path_factory.mktemp("reader") / "session.mcap")


@pytest.fixture(scope="module")
def chunked(tmp_path_factory):
    return written(tmp_path_factory.mktemp("chunked") / "session.mcap", chunked=True)


@pytest.mark.parametrize("is_chunked", [False, True])
def test_a_sound_file_is_read_whole_and_its_checksum_is_good(tmp_path, is_chunked):
    write(tmp_path / "session.mcap", chunked=is_chunked)
    reader = SessionReader(tmp_path)
    assert list(reader.messages()) == [message(k) for k in range(COUNT)]
    condition = reader.condition
    assert (condition.is_closed, condition.checksum, condition.damage) == (True, "good", [])
    assert condition.latest("session") == {"seed": "7"}
    assert condition.library == "session_log"


def test_only_the_topics_asked_for_are_given(tmp_path):
    write(tmp_path / "session.mcap")
    found = list(SessionReader(tmp_path).messages({"/t1"}))
    assert found == [message(k) for k in range(1, COUNT, 3)]


@given(cut=st.integers(9, 6000))
@settings(max_examples=60)
def test_a_file_cut_anywhere_gives_every_message_before_the_cut(sound, tmp_path_factory, cut):
    content, ends = sound
    path = tmp_path_factory.mktemp("cut") / "session.mcap"
    path.write_bytes(content[:cut])
    reader = SessionReader(path)
    ends = [end - CHECKSUM for end in ends]  # of the messages, before the checksums
    whole = sum(end <= min(cut, len(content)) for end in ends)
    assert list(reader.messages()) == [message(k) for k in range(whole)]
    if cut < ends[-1]:
        assert not reader.condition.is_closed
        lost = cut - max((end for end in ends if end <= cut), default=0)
        assert sum(d.length for d in reader.condition.damage) <= lost


@given(cut=st.integers(9, 14000))
@settings(max_examples=60)
def test_a_file_of_chunks_cut_anywhere_gives_every_commit_before_the_cut(
    tmp_path_factory, chunked, cut
):
    content, ends = chunked
    path = tmp_path_factory.mktemp("cut") / "session.mcap"
    path.write_bytes(content[:cut])
    reader = SessionReader(path)
    found = list(reader.messages())
    whole = sum(end <= min(cut, len(content)) for end in ends)
    assert found[:whole] == [message(k) for k in range(whole)]
    assert len(found) - whole in (0, 1)  # the cut may be in the index that follows a chunk
    assert reader.condition.is_closed == (cut >= len(content))


@given(
    start=st.integers(1500, 5000),
    length=st.integers(1, 400),
    filler=st.sampled_from(["zeros", "ones", "noise"]),
)
@example(start=2820, length=1, filler="ones")  # a length that would swallow two sound records
@settings(max_examples=80)
def test_what_lies_beside_a_damaged_stretch_is_read(sound, tmp_path_factory, start, length, filler):
    content, ends = sound
    noise = random.Random(start).randbytes(length)
    patch = {"zeros": bytes(length), "ones": b"\xff" * length, "noise": noise}[filler]
    damaged = content[:start] + patch + content[start + length :]
    path = tmp_path_factory.mktemp("hole") / "session.mcap"
    path.write_bytes(damaged)
    found = list(SessionReader(path).messages())
    begins = [0, *ends[:-1]]
    untouched = [
        message(k)
        for k, (begin, end) in enumerate(zip(begins, ends, strict=True))
        if end <= start or begin >= start + length
    ]
    missed = [m for m in untouched if m not in found]
    assert len(missed) <= 1  # the way is found again where two sound records follow each other


def test_a_hole_is_reported_with_its_place_and_the_messages_that_are_missing(sound, tmp_path):
    content, ends = sound
    start, end = ends[20], ends[23]
    (tmp_path / "session.mcap").write_bytes(content[:start] + bytes(end - start) + content[end:])
    result = read_summary(SessionReader(tmp_path))
    (damage,) = result.condition.damage
    assert (damage.offset, damage.length) == (start, end - start)
    assert (result.messages, result.missing) == (COUNT - 3, 3)


@pytest.mark.parametrize("is_chunked", [False, True])
def test_what_follows_the_ending_is_named_and_not_read(sound, chunked, tmp_path, is_chunked):
    content, _ = chunked if is_chunked else sound
    (tmp_path / "session.mcap").write_bytes(2 * content)  # two recordings in one file
    result = read_summary(SessionReader(tmp_path))
    (damage,) = result.condition.damage
    assert (damage.offset, damage.length) == (len(content), len(content))
    assert (result.messages, result.missing, result.condition.is_closed) == (COUNT, 0, True)


def test_a_changed_byte_inside_a_message_is_found_by_the_checksum(sound, tmp_path):
    content, ends = sound
    at = ends[20] - 3
    (tmp_path / "session.mcap").write_bytes(content[:at] + b"?" + content[at + 1 :])
    condition = read_summary(SessionReader(tmp_path)).condition
    assert condition.checksum == "wrong"


def test_lost_definitions_are_taken_from_the_files_ending(sound, tmp_path):
    content, ends = sound
    begin = content.index(b"string data") - 60
    patched = content[:begin] + bytes(ends[0] - begin) + content[ends[0] :]
    (tmp_path / "session.mcap").write_bytes(patched)
    found = list(SessionReader(tmp_path).messages())
    assert found == [message(k) for k in range(1, COUNT)]


@pytest.mark.parametrize(
    ("log_time", "follower"),
    [(5, b"\x05"), (NOW, b"\xff")],
    ids=["a time that cannot be", "nothing sound behind it"],
)
def test_bytes_that_only_look_like_a_record_are_not_taken_for_one(tmp_path, log_time, follower):
    def record(time):
        body = (1).to_bytes(2, "little") + (9).to_bytes(4, "little") + time.to_bytes(8, "little")
        body += time.to_bytes(8, "little") + b"forged"
        return b"\x05" + len(body).to_bytes(8, "little") + body

    forged = record(log_time) + (record(log_time) if follower == b"\x05" else follower * 40)
    writer = UnchunkedWriter(tmp_path / "session.mcap")
    for k, data in enumerate([b"first", forged, b"third", b"fourth"]):
        writer.add(Message(SOURCES[0], data, NOW + k, k + 1))
        writer.commit()
        if k == 0:
            broken = writer.committed
    writer.close()
    content = bytearray((tmp_path / "session.mcap").read_bytes())
    content[broken] = 0xEE  # the opcode of the message that carries the forged ones
    (tmp_path / "session.mcap").write_bytes(content)
    found = [m.data for m in SessionReader(tmp_path).messages()]
    assert found == [b"first", b"third", b"fourth"]


def test_a_damaged_chunk_costs_only_itself(tmp_path):
    path = tmp_path / "session.mcap"
    writer = SessionWriter(path)
    for k in range(3):
        noise = random.Random(k).randbytes(2_000_000)
        writer.add(Message(SOURCES[0], noise, NOW + k, k + 1))
    writer.close()
    content = bytearray(path.read_bytes())
    content[3_000_000] ^= 0xFF
    path.write_bytes(content)
    result = read_summary(SessionReader(path))
    assert [d.what for d in result.condition.damage] == ["damaged chunk"]
    assert (result.messages, result.missing) == (2, 1)


def test_a_damaged_beginning_is_read_only_when_asked_for(sound, tmp_path):
    content, _ = sound
    (tmp_path / "session.mcap").write_bytes(b"\0" * 8 + content[8:])
    with pytest.raises(NotASession, match="not an MCAP recording: it begins with"):
        SessionReader(tmp_path)
    assert len(list(SessionReader(tmp_path, tolerant=True).messages())) == COUNT


def test_memory_stays_constant_over_a_long_file(tmp_path):
    def peak(count):
        path = tmp_path / f"{count}.mcap"
        write(path, count=count)
        tracemalloc.start()
        for _ in SessionReader(path).messages():
            pass
        _, most = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        return most

    assert peak(2000) < peak(200) + 2_000_000 < 6_000_000


@pytest.mark.parametrize(
    ("content", "words"),
    [(b"", "it is empty"), (b"#ROSBAG V2.0\n", "it begins with b'#ROSBAG")],
)
def test_another_kind_of_file_is_refused_by_name(tmp_path, content, words):
    (tmp_path / "x").write_bytes(content)
    with pytest.raises(NotASession, match=words):
        SessionReader(tmp_path / "x")


@pytest.mark.parametrize(
    ("name", "content", "helps"),
    [("s.mcap", b"\x88MCAP0\r\n...", True), ("s.mcap", b"", False), ("s.bag", b"#ROSBAG", False)],
)
def test_a_damaged_beginning_names_the_command_that_may_help(tmp_path, name, content, helps):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(NotASession) as refused:
        SessionReader(tmp_path / name)
    assert str(refused.value).endswith(", `session_log recover` may help") == helps
    assert ("recover" in str(refused.value)) == helps


def test_a_missing_file_and_an_empty_folder_are_named(tmp_path):
    with pytest.raises(SessionMissing, match="none: no such file"):
        SessionReader(tmp_path / "none")
    with pytest.raises(SessionMissing, match=r"a folder without session\.mcap"):
        SessionReader(tmp_path)


def test_a_disk_that_fails_is_named_with_the_recording(sound, tmp_path, monkeypatch):
    (tmp_path / "session.mcap").write_bytes(sound[0])
    reader = SessionReader(tmp_path)
    break_reading(monkeypatch)
    with pytest.raises(SessionMissing, match=r"session\.mcap: Input/output error"):
        list(reader.messages())
    with pytest.raises(SessionMissing, match=r"session\.mcap: Input/output error"):
        SessionReader(tmp_path)


def test_an_error_of_who_reads_is_none_of_the_recording(sound, tmp_path):
    (tmp_path / "session.mcap").write_bytes(sound[0])
    with pytest.raises(OSError, match="No space left"):
        for _ in SessionReader(tmp_path).messages():
            raise OSError(28, "No space left")

# SPDX-License-Identifier: BSD-3-Clause
import json
import struct
import wave
from dataclasses import replace

import pytest

from session_log.errors import SessionMissing
from session_log.export.export import ParquetMissing, export_topics, flatten
from session_log.mcap_file.decoder import Decoder
from session_log.mcap_file.reader import SessionReader
from session_log.types import Message, MessageSource
from support.story import START, Story, numbered, recording_of
from tests.unit.session_log.support.broken_disk import break_reading
from tests.unit.session_log.support.foreign import write_foreign
from tests.unit.session_log.support.voice_recording import say_sound

AUDIO = "/voice_assist/audio"


def test_lost_sound_becomes_silence_of_the_same_length(tmp_path):
    story = Story()
    for first, value in ((0, 100), (512, 200), (2048, 300)):
        say_sound(story, first / 16000, first, value)
    session = recording_of(tmp_path / "s.mcap", story.messages)
    result = export_topics(session, tmp_path / "out", [], AUDIO)
    assert (result.samples, result.lost_samples) == (1536, 1024)
    with wave.open(str(result.sound)) as sound:
        content = sound.readframes(sound.getnframes())
    values = [int.from_bytes(content[i : i + 2], "little") for i in range(0, len(content), 2)]
    assert values == [100] * 512 + [200] * 512 + [0] * 1024 + [300] * 512


@pytest.mark.parametrize("is_stamped", [True, False])
def test_a_restart_of_the_voice_node_becomes_silence_by_the_stamps(tmp_path, is_stamped):
    story = Story()
    for time, value in ((1.0, 100), (1.5, 200)):
        say_sound(story, time, 0, value)
    delay = 0
    for k, message in enumerate(story.messages):
        if is_stamped:  # what arrives late was captured when its stamp says
            delay = 10**9 * (k + 1)
        data = message.data if is_stamped else message.data[:4] + bytes(8) + message.data[12:]
        story.messages[k] = message._replace(data=data, log_time=message.log_time + delay)
    session = recording_of(tmp_path / "s.mcap", story.messages)
    result = export_topics(session, tmp_path / "out", [], AUDIO)
    with wave.open(str(result.sound)) as sound:
        assert sound.getnframes() == 8000 + 512
    assert (result.samples, result.lost_samples) == (1024, 8000 - 512)
    assert result.sound_start == START + 10**9


def test_parquet_without_pyarrow_says_what_to_install_and_writes_nothing(monkeypatch, tmp_path):
    monkeypatch.setattr("session_log.export.export.find_spec", lambda name: None)
    reader = recording_of(tmp_path / "s.mcap")
    with pytest.raises(ParquetMissing, match=r"requirements-parquet\.txt.*--format csv"):
        export_topics(reader, tmp_path / "out", [], "/a", ("csv", "parquet"))
    assert not (tmp_path / "out").exists()


def test_topics_of_one_plain_name_and_of_two_types_have_a_file_each(tmp_path):
    story = Story()
    story.say(0.0, "/a_b", "std_msgs/String", data="flat")
    story.say(0.1, "/a/b", "std_msgs/String", data="nested")
    story.say(0.2, "/a/b_2", "std_msgs/String", data="numbered")
    del story.sources["/a/b"]
    story.say(0.3, "/a/b", "voice_assist/Mode", mode="active", reason="second")
    reader = recording_of(tmp_path / "s.mcap", numbered(story.messages))
    result = export_topics(reader, tmp_path / "out", ["/a_b", "/a/b_2", "/a/b"], "/none")
    found = {path.stem: path.read_text("utf-8").split(",")[-1].strip() for path in result.rows}
    assert found == {"a_b": "nested", "a_b_2": "numbered", "a_b_3": "flat", "a_b_4": "second"}
    assert set(result.rows.values()) == {1} and result.topics == {"/a_b", "/a/b", "/a/b_2"}


@pytest.mark.parametrize(("md5sum", "rows"), [("", [1, 1]), ("1" * 32, [2])])
def test_two_definitions_have_a_file_each_unless_their_md5_sum_says_that_they_are_one(
    tmp_path, md5sum, rows
):
    sources = [MessageSource("/t", "a/T", md5sum, f"int8 {name}\n") for name in ("x", "x #[m]")]
    if not md5sum:
        sources[1] = replace(sources[1], definition="int8 x\nint8 y")
    messages = [Message(s, bytes(1 if md5sum else k), 10**18, k) for k, s in enumerate(sources, 1)]
    result = export_topics(recording_of(tmp_path / "s.mcap", messages), tmp_path, ["/t"], "/none")
    assert list(result.rows.values()) == rows and not result.undecodable
    heads = [path.read_text("utf-8").splitlines()[0] for path in result.rows]
    assert heads == ["log_time,x", "log_time,x,y"][: len(rows)]


def test_sound_of_another_rate_than_the_first_is_left_out_and_named(tmp_path):
    story = Story()
    for first, rate in ((0, 16_000), (1, 8_000), (1, 16_000)):
        say_sound(story, 0.0, first, rate=rate, count=1)
    reader = recording_of(tmp_path / "s.mcap", story.messages)
    result = export_topics(reader, tmp_path / "out", [], AUDIO)
    assert (result.samples, result.undecodable) == (2, 1)
    assert "rate is 8000 Hz, in audio.wav it is 16000" in result.unfit[AUDIO]


@pytest.mark.parametrize(
    ("datatype", "fields"),
    [
        ("voice_assist/AudioChunk", {"rate": 2**32 - 1, "samples": [1]}),
        ("std_msgs/String", {"data": "x"}),
        ("voice_assist/AudioChunk", {"rate": 0, "samples": [1]}),
    ],
)
def test_sound_of_another_type_is_counted_and_the_tables_are_whole(tmp_path, datatype, fields):
    story = Story()
    story.say(0.0, "/sound", datatype, **fields)
    story.say(0.1, "/t", "std_msgs/String", data="later")
    reader = recording_of(tmp_path / "s.mcap", story.messages)
    result = export_topics(reader, tmp_path / "out", ["/t", "/sound"], "/sound")
    assert (result.undecodable, result.sound, list(result.unfit)) == (1, None, ["/sound"])
    assert {path.name: rows for path, rows in result.rows.items()} == {"sound.csv": 1, "t.csv": 1}


def test_sound_with_another_header_is_counted(tmp_path):
    source = MessageSource(AUDIO, "a/T", "", "int32 header\nuint32 rate\nuint64 first_sample\n")
    reader = recording_of(tmp_path / "s.mcap", [Message(source, bytes(16), 10**18, 1)])
    result = export_topics(reader, tmp_path / "out", [], AUDIO)
    assert (result.undecodable, result.sound, list(result.unfit)) == (1, None, [AUDIO])


def test_messages_of_another_encoding_are_counted_and_not_written(tmp_path):
    reader = SessionReader(write_foreign(tmp_path / "s.mcap"))
    result = export_topics(reader, tmp_path / "out", ["/t"], "/none")
    assert (result.undecodable, result.rows) == (1, {})
    assert "recorded as 'cdr' with schema 'ros2msg'" in result.unfit["/t"]


def test_a_disk_that_fails_while_it_is_read_names_the_recording(tmp_path, monkeypatch):
    reader = recording_of(tmp_path / "s.mcap")
    break_reading(monkeypatch)
    with pytest.raises(SessionMissing, match=r"s\.mcap: Input/output error"):
        export_topics(reader, tmp_path / "out", [], "/a")


@pytest.mark.parametrize("error", [KeyboardInterrupt, SessionMissing])
def test_an_export_that_is_broken_off_leaves_the_tables_of_the_one_before(
    tmp_path, monkeypatch, error
):
    story = Story()
    story.say(0.0, "/t", "std_msgs/String", data="whole")
    export_topics(recording_of(tmp_path / "a.mcap", story.messages), tmp_path / "o", ["/t"], "/a")
    reader = recording_of(tmp_path / "b.mcap", story.messages)

    def broken_off(topics):
        yield story.messages[0]._replace(data=b"\3\0\0\0new")
        raise error(tmp_path, "unreadable")

    monkeypatch.setattr(reader, "messages", broken_off)
    with pytest.raises(error):
        export_topics(reader, tmp_path / "o", ["/t"], "/a", ("csv", "parquet"))
    (left,) = (tmp_path / "o").iterdir()
    assert left.name == "t.csv" and "whole" in left.read_text("utf-8")


def test_a_topic_that_is_named_twice_has_one_file_of_its_plain_name(tmp_path):
    story = Story()
    story.say(0.0, "/t", "std_msgs/String", data="x")
    reader = recording_of(tmp_path / "s.mcap", story.messages)
    result = export_topics(reader, tmp_path / "o", ["/t", "/t"], "/a")
    assert [path.name for path in result.rows] == ["t.csv"]


def flat(definition, layout, *values):
    """The fields of a message of one definition, for a table."""
    source = MessageSource("/t", "test_msgs/T", "", definition)
    message = Message(source, struct.pack(f"<{layout}", *values), 0, 1)
    return dict(flatten(Decoder().decode(message)))


@pytest.mark.parametrize(
    ("seconds", "nanoseconds", "words"),
    [
        (-1, 500_000_000, "-0.500000000"),
        (-2, 999_999_999, "-1.000000001"),
        (-1, 0, "-1.000000000"),
        (0, 0, "0.000000000"),
        (5, 7, "5.000000007"),
    ],
)
def test_a_duration_has_one_sign(seconds, nanoseconds, words):
    assert flat("duration d", "ii", seconds, nanoseconds) == {"d": words}
    assert flat("duration[] d", "Iii", 1, seconds, nanoseconds) == {"d": json.dumps([words])}


def test_times_in_a_list_are_written_as_elsewhere():
    assert flat("time[] t", "IIIII", 2, 5, 7, 6, 0) == {"t": '["5.000000007", "6.000000000"]'}


def test_a_list_with_numbers_that_are_not_finite_is_json():
    values = (float("nan"), 1.0, float("inf"))
    assert flat("float64[3] x", "ddd", *values) == {"x": "[null, 1.0, null]"}


def test_messages_in_a_list_are_one_json_text_with_all_that_is_in_them():
    inner = "float32 x\nduration d\nint8[] n\nuint8[] raw"
    separator = "=" * 80
    definition = f"Inner[] list\n{separator}\nMSG: test_msgs/Inner\n{inner}"
    values = (1, float("nan"), -1, 500_000_000, 2, 3, 4, 2, 1, 255)
    found = flat(definition, "IfiiIbbIBB", *values)
    entry = {"x": None, "d": "-0.500000000", "n": [3, 4], "raw": "01ff"}
    assert json.loads(found["list"]) == [entry]

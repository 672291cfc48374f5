# SPDX-License-Identifier: BSD-3-Clause
import csv
import json
import tracemalloc

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from session_log.cli import main
from session_log.export import parquet
from session_log.export.export import export_topics, flatten
from session_log.mcap_file.decoder import Decoder
from session_log.mcap_file.reader import SessionReader
from support.story import Story, numbered, recording_of, write_session

TOPICS = [
    "/voice_assist/utterance",
    "/rst_control/state",
    "/joint_states",
    "/diagnostics",
    "/robot/scene/compressed",
]


@pytest.fixture(scope="module")
def exported(story, tmp_path_factory):
    folder = tmp_path_factory.mktemp("both")
    export_topics(SessionReader(story[0]), folder, TOPICS, "/none", ("csv", "parquet"))
    return folder


def stem(topic):
    return topic.strip("/").replace("/", "_")


@pytest.mark.parametrize("topic", TOPICS)
def test_a_table_holds_every_message_as_it_was_recorded(story, exported, topic):
    decoder = Decoder()
    messages = [m for m in story[1] if m.source.topic == topic]
    table = pq.read_table(exported / f"{stem(topic)}.parquet")
    times = [f.name for f in table.schema if (f.metadata or {}).get(b"unit")]
    rows = table.to_pylist()
    assert [row["log_time"] for row in rows] == [m.log_time for m in messages]
    for row, message in zip(rows, messages, strict=True):
        content = decoder.decode(message)
        said = {name: value for name, value in flatten(content) if name not in times}
        assert {name: plain(row[name]) for name in said} == said | nested(row)
        stamp = content.header.stamp
        assert row["header.stamp"] == stamp.secs * 10**9 + stamp.nsecs


def plain(value):
    """As the CSV has it: lists as JSON, bytes in hexadecimal."""
    if isinstance(value, list):
        return json.dumps(value)
    return value.hex() if isinstance(value, bytes) else value


def nested(row):
    """Lists of messages, which have a test of their own."""
    return {
        n: plain(v) for n, v in row.items() if isinstance(v, list) and v and isinstance(v[0], dict)
    }


@pytest.mark.parametrize("topic", TOPICS)
def test_csv_and_parquet_say_the_same(exported, topic):
    table = pq.read_table(exported / f"{stem(topic)}.parquet")
    with (exported / f"{stem(topic)}.csv").open(newline="", encoding="utf-8") as file:
        lines = list(csv.DictReader(file))
    assert len(lines) == table.num_rows > 0
    for name in table.column_names:
        kind, values = table.schema.field(name).type, table[name].to_pylist()
        cells = [line[name] for line in lines]
        if name == "log_time" or (table.schema.field(name).metadata or {}).get(b"unit"):
            assert cells == [f"{v // 10**9}.{v % 10**9:09d}" for v in values], name
        elif pa.types.is_floating(kind):
            assert [float(c) for c in cells] == values, name
        elif pa.types.is_list(kind) and not pa.types.is_struct(kind.value_type):
            assert [json.loads(c) for c in cells] == values, name
        elif pa.types.is_string(kind) or pa.types.is_integer(kind) or pa.types.is_boolean(kind):
            assert cells == [str(v) for v in values], name
        elif pa.types.is_binary(kind):
            assert cells == [v.hex() for v in values], name


def test_columns_have_the_types_and_units_of_the_definition(exported):
    schema = pq.read_schema(exported / "voice_assist_utterance.parquet")
    assert schema.field("confidence").type == pa.float32()
    assert schema.field("is_partial").type == pa.bool_()
    assert schema.field("wer").type.value_type == pa.float32()
    assert schema.field("phrases").type.value_type == pa.string()
    assert schema.field("header.seq").type == pa.uint32()
    for name in ("log_time", "header.stamp", "speech_end", "decision"):
        assert schema.field(name).type == pa.int64()
        assert schema.field(name).metadata[b"unit"] == b"ns since 1970-01-01T00:00:00Z"
    assert schema.field("confidence").metadata[b"comment"] == b"[0, 1]"
    assert schema.metadata[b"topic"] == b"/voice_assist/utterance"
    assert schema.metadata[b"type"] == b"voice_assist/Utterance"
    assert b"string transcript" in schema.metadata[b"definition"]


def test_nested_messages_in_a_list_are_structs(exported):
    (first, *_) = pq.read_table(exported / "diagnostics.parquet")["status"].to_pylist()
    (status,) = first
    assert (status["name"], status["level"]) == ("controller: loop", 0)
    assert status["values"] == [{"key": "late ticks", "value": "0"}]


def parquet_of(story, folder):
    """Write a table of what a story says on /a."""
    reader = recording_of(folder / "s.mcap", story.messages)
    export_topics(reader, folder, ["/a"], "/none", ("parquet",))


def test_the_extremes_of_every_number_survive(tmp_path):
    story = Story()
    fields = {"first_sample": 2**64 - 1, "rate": 2**32 - 1, "samples": [-32768, 0, 32767]}
    story.say(0.0, "/a", "voice_assist/AudioChunk", **fields)
    parquet_of(story, tmp_path)
    (row,) = pq.read_table(tmp_path / "a.parquet").to_pylist()
    assert {name: row[name] for name in fields} == fields


def test_a_topic_that_changes_its_type_goes_on_in_a_second_file(tmp_path):
    story = Story()
    story.say(0.0, "/a", "std_msgs/String", data="one")
    del story.sources["/a"]
    story.say(1.0, "/a", "voice_assist/Mode", mode="active", reason="two")
    reader = recording_of(tmp_path / "s.mcap", numbered(story.messages))
    result = export_topics(reader, tmp_path, ["/a"], "/none", ("csv", "parquet"))
    assert sorted(path.name for path in result.rows) == [
        "a.csv",
        "a.parquet",
        "a_2.csv",
        "a_2.parquet",
    ]
    assert pq.read_table(tmp_path / "a.parquet")["data"].to_pylist() == ["one"]
    assert pq.read_table(tmp_path / "a_2.parquet")["reason"].to_pylist() == ["two"]


def test_rows_are_written_in_groups(tmp_path, monkeypatch):
    monkeypatch.setattr(parquet, "GROUP_ROWS", 100)
    story = Story()
    for k in range(250):
        story.say(k * 0.01, "/a", "std_msgs/String", data=f"{k}")
    parquet_of(story, tmp_path)
    file = pq.ParquetFile(tmp_path / "a.parquet")
    sizes = [file.metadata.row_group(k).num_rows for k in range(file.num_row_groups)]
    assert sizes == [100, 100, 50]
    assert file.read()["data"].to_pylist() == [f"{k}" for k in range(250)]


def test_large_messages_make_smaller_groups(tmp_path, monkeypatch):
    monkeypatch.setattr(parquet, "GROUP_SIZE", 1_000)
    story = Story()
    for _ in range(5):
        story.say(0.0, "/a", "std_msgs/String", data="x" * 400)
    parquet_of(story, tmp_path)
    assert pq.ParquetFile(tmp_path / "a.parquet").num_row_groups == 2


def test_memory_does_not_grow_with_the_session(tmp_path, monkeypatch):
    monkeypatch.setattr(parquet, "GROUP_ROWS", 200)

    def peak(messages, run):
        story = Story()
        for k in range(messages):
            story.say(k * 1e-3, "/a", "std_msgs/String", data=f"{k:>2000}")
        path = tmp_path / f"{messages}_{run}.mcap"
        reader = recording_of(path, story.messages)
        del story
        before = pa.total_allocated_bytes()
        tracemalloc.start()
        export_topics(reader, tmp_path / f"{run}", ["/a"], "/none", ("csv", "parquet"))
        _, most = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        return most + pa.total_allocated_bytes() - before

    peak(400, 1)  # what is loaded only once
    few, many = peak(400, 2), peak(4000, 3)
    assert many < few + 0.5 * (4000 - 400) * 2000, "less than the messages themselves"
    assert many < 1.5 * few


@pytest.mark.parametrize(
    ("words", "endings"),
    [
        ([], {".csv"}),
        (["--format", "csv"], {".csv"}),
        (["--format", "parquet"], {".parquet"}),
        (["--format", "both"], {".csv", ".parquet"}),
    ],
)
def test_the_format_is_chosen_on_the_command_line(tmp_path, words, endings):
    write_session(tmp_path / "s.mcap", duration=6.0, rate=20)
    out = tmp_path / "out"
    with pytest.raises(SystemExit) as end:
        main(["export", str(tmp_path / "s.mcap"), "--out", str(out), *words])
    assert end.value.code == 0
    assert {path.suffix for path in out.iterdir()} - {".wav"} == endings
    assert (out / "audio.wav").exists()


def test_an_unwritable_folder_is_one_clear_line(story, tmp_path, capsys):
    (tmp_path / "file").write_text("")
    words = ["export", str(story[0]), "--format", "parquet", "--out", str(tmp_path / "file" / "x")]
    with pytest.raises(SystemExit) as end:
        main(words)
    assert end.value.code == 1
    assert "cannot write" in capsys.readouterr().err

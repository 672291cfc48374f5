# SPDX-License-Identifier: BSD-3-Clause
"""Recordings in the hands of the public readers: by index, as a stream, and up to a cut."""

import json
import os
import shutil
import subprocess
from pathlib import Path

import pytest
from mcap.reader import make_reader
from mcap.records import Chunk
from mcap.stream_reader import StreamReader

from session_log.mcap_file.writer import SessionWriter
from session_log.types import Message, MessageSource
from tests.unit.session_log.support.public_reader import streamed

ROOT = Path(__file__).resolve().parents[4]
MODULES = ROOT / ".setup" / "node" / "node_modules"
SCRIPT = Path(__file__).parents[1] / "support" / "read_mcap.cjs"
SOURCE = MessageSource("/t", "std_msgs/String", "992c", "string data", "/p")
BEGIN = 1_795_200_000 * 10**9  # [ns]
PERIOD = 10**7  # [ns] between two messages
COUNT, PER_COMMIT = 600, 5

NEEDED = {"node": shutil.which("node"), "@mcap/core": (MODULES / "@mcap" / "core").is_dir()}
MISSING = " and ".join(name for name, found in NEEDED.items() if not found)

needs_javascript = pytest.mark.skipif(
    bool(MISSING),
    reason=f"{MISSING} missing: install nodejs and npm, then run docker/setup.sh javascript",
)


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    """Content of a closed file, and its size after each commit."""
    path = tmp_path_factory.mktemp("public") / "session.mcap"
    ends = []
    with SessionWriter(path) as writer:
        for k in range(COUNT):
            text = b"%d" % k
            data = len(text).to_bytes(4, "little") + text
            writer.add(Message(SOURCE, data, BEGIN + k * PERIOD, k + 1))
            if k % PER_COMMIT == PER_COMMIT - 1:
                writer.add_metadata("parameters", {"k": str(k)})
                writer.commit()
                ends.append(writer.committed)
    return path.read_bytes(), ends


def cut_inside(recording, commits, path):
    """A file as a kill leaves it: some commits, and a part of the next."""
    content, ends = recording
    path.write_bytes(content[: (ends[commits - 1] + ends[commits]) // 2])
    return path


def javascript(path):
    done = subprocess.run(
        ["node", str(SCRIPT), str(path)],
        env={**os.environ, "NODE_PATH": str(MODULES)},
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
    )
    return json.loads(done.stdout)


def test_python_reads_a_closed_file_by_its_index(recording, tmp_path):
    path = tmp_path / "s.mcap"
    path.write_bytes(recording[0])
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        assert summary.statistics.message_count == COUNT
        assert len(summary.chunk_indexes) == COUNT // PER_COMMIT
        since = BEGIN + 400 * PERIOD
        later = [m.sequence for _, _, m in reader.iter_messages(start_time=since)]
        assert later == list(range(401, COUNT + 1))
        file.seek(0)
        chunks = [r for r in StreamReader(file, emit_chunks=True).records if isinstance(r, Chunk)]
    assert {chunk.compression for chunk in chunks} == {"zstd"}


def test_python_reads_a_killed_file_up_to_the_cut(recording, tmp_path):
    path = cut_inside(recording, 80, tmp_path / "s.mcap")
    found = streamed(path)
    assert len(found) // PER_COMMIT in (80, 81)  # the cut may lie behind the next chunk


@needs_javascript
def test_javascript_reads_a_closed_file_by_its_index(recording, tmp_path):
    path = tmp_path / "s.mcap"
    path.write_bytes(recording[0])
    index = javascript(path)["index"]
    assert index["chunks"] == COUNT // PER_COMMIT
    assert (index["count"], index["all"], index["channels"]) == (COUNT, COUNT, 1)
    assert 0 < index["messages"] < COUNT  # of five seconds, sought by time


@needs_javascript
def test_javascript_reads_a_killed_file_up_to_the_cut(recording, tmp_path):
    found = javascript(cut_inside(recording, 80, tmp_path / "s.mcap"))
    assert "refusal" in found and not found["stream"]["done"]
    sequences = found["stream"]["sequences"]
    assert sequences == list(range(1, len(sequences) + 1))
    assert len(sequences) // PER_COMMIT in (80, 81)

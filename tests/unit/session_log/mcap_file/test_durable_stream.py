# SPDX-License-Identifier: BSD-3-Clause
import errno
import os

import pytest

from session_log.errors import RecordingFailed
from session_log.mcap_file.durable_stream import DurableStream


class FillingDisk:
    """A disk with so much room; then it writes part of what it is given and fails."""

    def __init__(self, room):
        self.room = room

    def write(self, fd, data):
        if self.room <= 0:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        part = data[: self.room]
        self.room -= len(part)
        return os.write(fd, part)


def test_nothing_reaches_the_file_before_the_commit(tmp_path):
    stream = DurableStream(tmp_path / "f")
    stream.write(b"abc")
    assert (tmp_path / "f").read_bytes() == b""
    assert (stream.tell(), stream.committed) == (3, 0)
    stream.flush()
    assert (tmp_path / "f").read_bytes() == b"abc"
    assert (stream.tell(), stream.committed) == (3, 3)


def test_a_full_disk_leaves_no_half_commit_and_names_file_and_reason(tmp_path):
    disk = FillingDisk(room=5)
    stream = DurableStream(tmp_path / "f", write=disk.write)
    stream.write(b"whole")
    stream.flush()
    disk.room = 3
    stream.write(b"half of it")
    with pytest.raises(RecordingFailed, match="f: No space left on device"):
        stream.flush()
    assert (tmp_path / "f").read_bytes() == b"whole"


def test_what_a_full_disk_refused_is_written_when_there_is_room_again(tmp_path):
    disk = FillingDisk(room=2)
    stream = DurableStream(tmp_path / "f", write=disk.write)
    stream.write(b"abcd")
    with pytest.raises(RecordingFailed):
        stream.flush()
    stream.write(b"ef")
    disk.room = 100
    stream.flush()
    assert (tmp_path / "f").read_bytes() == b"abcdef"


def test_a_sync_waits_for_the_disk(tmp_path, monkeypatch):
    waited = []
    monkeypatch.setattr("os.fdatasync", waited.append)
    stream = DurableStream(tmp_path / "f")
    stream.sync()
    assert waited == [stream._fd]


def test_an_existing_file_is_never_overwritten(tmp_path):
    (tmp_path / "f").write_bytes(b"a recording")
    with pytest.raises(RecordingFailed, match="File exists"):
        DurableStream(tmp_path / "f")
    assert (tmp_path / "f").read_bytes() == b"a recording"


@pytest.mark.parametrize("look", [DurableStream.sync, DurableStream.check])
def test_a_file_deleted_while_it_is_written_is_an_error(tmp_path, look):
    stream = DurableStream(tmp_path / "f")
    look(stream)
    (tmp_path / "f").unlink()
    with pytest.raises(RecordingFailed, match="deleted while"):
        look(stream)


def test_looking_for_the_file_waits_for_no_disk(tmp_path, monkeypatch):
    monkeypatch.setattr("os.fdatasync", pytest.fail)
    DurableStream(tmp_path / "f").check()

# SPDX-License-Identifier: BSD-3-Clause
"""Files of the writer, read by the public libraries alone."""

import errno
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from mcap.reader import make_reader
from mcap_ros1.decoder import DecoderFactory

from session_log.errors import RecordingFailed
from session_log.mcap_file import writer as writer_module
from session_log.mcap_file.durable_stream import DurableStream
from session_log.mcap_file.reader import SessionReader
from session_log.mcap_file.session_folder import open_session
from session_log.mcap_file.writer import SessionWriter
from session_log.types import Message, MessageSource
from support.message_classes import class_of, serialise, source_of
from tests.unit.session_log.support.public_reader import streamed

ROOT = Path(__file__).resolve().parents[4]
NOW = 1_795_200_000_000_000_000
KILLS = 20


def event(kind, sequence=1):
    message = class_of("rst_control/Event")(kind=kind, command="stop")
    source = source_of("/rst_control/event", "rst_control/Event", "/controller")
    return Message(source, serialise(message), NOW + sequence, sequence)


def test_a_closed_file_is_read_by_mcap_alone(tmp_path):
    with SessionWriter(tmp_path / "s.mcap") as writer:
        writer.add_metadata("session", {"seed": "7"})
        for k in range(3):
            writer.add(event(f"kind {k}", k + 1))
    with (tmp_path / "s.mcap").open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()], validate_crcs=True)
        assert reader.get_header().profile == "ros1"
        summary = reader.get_summary()
        assert summary.statistics.message_count == 3
        assert [s.encoding for s in summary.schemas.values()] == ["ros1msg"]
        decoded = [d for *_, d in reader.iter_decoded_messages()]
        assert [d.kind for d in decoded] == ["kind 0", "kind 1", "kind 2"]
        assert [m.metadata for m in reader.iter_metadata()] == [{"seed": "7"}]


def test_the_channel_names_publisher_type_and_latching(tmp_path):
    source = source_of("/mode", "voice_assist/Mode", "/voice", is_latched=True)
    data = serialise(class_of("voice_assist/Mode")())
    with SessionWriter(tmp_path / "s.mcap") as writer:
        writer.add(Message(source, data, NOW, 1))
    with (tmp_path / "s.mcap").open("rb") as file:
        channel = next(iter(make_reader(file).get_summary().channels.values()))
    kind = class_of("voice_assist/Mode")
    expected = {"md5sum": kind._md5sum, "callerid": "/voice", "latching": "1"}
    assert (channel.topic, channel.metadata) == ("/mode", expected)


def test_two_publishers_of_a_topic_are_distinguished_and_share_a_schema(tmp_path):
    data = serialise(class_of("voice_assist/Mode")())
    with SessionWriter(tmp_path / "s.mcap") as writer:
        for name in ("/a", "/b"):
            writer.add(Message(source_of("/mode", "voice_assist/Mode", name), data, NOW, 1))
    with (tmp_path / "s.mcap").open("rb") as file:
        summary = make_reader(file).get_summary()
    assert (len(summary.channels), len(summary.schemas)) == (2, 1)


def test_a_type_that_nobody_here_knows_is_kept_byte_for_byte(tmp_path):
    source = MessageSource("/odd", "strange_msgs/Odd", "0" * 32, "this is no definition", "/x")
    with SessionWriter(tmp_path / "s.mcap") as writer:
        writer.add(Message(source, b"\0\xff raw", NOW, 1))
    with (tmp_path / "s.mcap").open("rb") as file:
        ((schema, channel, message),) = make_reader(file).iter_messages()
    assert (schema.name, channel.topic, message.data) == ("strange_msgs/Odd", "/odd", b"\0\xff raw")


def test_what_was_committed_is_readable_while_the_file_is_still_open(tmp_path):
    writer = SessionWriter(tmp_path / "s.mcap")
    writer.add(event("accepted"))
    writer.commit()
    (message,) = SessionReader(tmp_path / "s.mcap").messages()
    assert message == event("accepted")
    writer.abandon()


def test_a_folder_that_does_not_exist_is_named(tmp_path):
    with pytest.raises(RecordingFailed, match=r"no/s.mcap: No such file"):
        SessionWriter(tmp_path / "no" / "s.mcap")


def test_a_disk_that_is_full_from_the_start_keeps_no_empty_file(tmp_path, monkeypatch):
    """The recorder tries again every half second: each try would leave a file that stays open."""

    def refuse(fd, data):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    def opened():
        links = map(os.path.realpath, Path("/proc/self/fd").iterdir())
        return [file for file in links if file.startswith(str(tmp_path))]

    with monkeypatch.context() as disk:
        disk.setattr(writer_module, "DurableStream", lambda path: DurableStream(path, refuse))
        for _ in range(3):
            with pytest.raises(RecordingFailed, match="No space left"):
                open_session(tmp_path, "name", NOW)
    assert list((tmp_path / "name").iterdir()) == []
    assert opened() == []
    with open_session(tmp_path, "name", NOW) as writer:
        assert writer.path.name == "session.mcap"


def test_a_disk_that_becomes_read_only_meanwhile_is_named(tmp_path, monkeypatch):
    def refuse(*_, **__):
        raise OSError(errno.EROFS, os.strerror(errno.EROFS))

    monkeypatch.setattr(writer_module, "DurableStream", lambda path: DurableStream(path, refuse))
    monkeypatch.setattr(Path, "unlink", refuse)
    with pytest.raises(RecordingFailed, match="Read-only file system"):
        SessionWriter(tmp_path / "s.mcap")


WRITE_UNTIL_KILLED = """
import sys
from pathlib import Path
from session_log.types import Message, MessageSource
from session_log.mcap_file.writer import SessionWriter
source = MessageSource("/t", "std_msgs/String", "99" * 16, "string data", "/w")
writer = SessionWriter(Path(sys.argv[1]))
for k in range(1, 10**9):
    text = (b"%d" % k) * 40
    writer.add(Message(source, len(text).to_bytes(4, "little") + text, 1795200000 * 10**9 + k, k))
    if k % 3 == 0:
        writer.commit()
        sys.stdout.write("%d\\n" % k)
        sys.stdout.flush()
"""


def test_sigkill_takes_nothing_that_was_acknowledged(tmp_path):
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    for kill in range(KILLS):
        path = tmp_path / f"{kill}.mcap"
        process = subprocess.Popen(
            [sys.executable, "-c", WRITE_UNTIL_KILLED, str(path)],
            stdout=subprocess.PIPE,
            env=environment,
            cwd=ROOT,
        )
        for _ in range(1 + 37 * kill):
            process.stdout.readline()
        process.send_signal(signal.SIGKILL)
        lines = process.stdout.read().split(b"\n")
        process.wait()
        acknowledged = max((int(line) for line in lines[:-1] if line), default=3)
        assert len(streamed(path)) >= acknowledged
        assert sum(1 for _ in SessionReader(path).messages()) >= acknowledged

# SPDX-License-Identifier: BSD-3-Clause
"""Whatever happened to a file: recovery never raises, reports what is lost, and invents nothing."""

from __future__ import annotations

import random
import struct
from collections import Counter
from dataclasses import dataclass
from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader

from session_log.mcap_file.reader import SessionReader
from session_log.mcap_file.records import CHUNK, DATA_END, HEAD, MAGIC, MESSAGE_INDEX
from session_log.mcap_file.recover import recover
from session_log.mcap_file.writer import SessionWriter
from session_log.types import Message, MessageSource
from tests.unit.session_log.support.unchunked import UnchunkedWriter

NOW = 1_795_200_000_000_000_000  # [ns]
SOURCES = [
    MessageSource(
        "/joint_states", "a/Joints", "1" * 32, "Header header\nfloat64[] position", "/robot"
    ),
    MessageSource("/event", "a/Event", "2" * 32, "string kind", "/controller", is_latched=True),
    MessageSource("/sound", "a/Sound", "3" * 32, "int16[] samples", "/voice"),
]
COUNT = 90
EXAMPLES = 150


@dataclass(frozen=True, repr=False)
class Recording:
    """A sound file, and where each message lies in it."""

    content: bytes
    messages: list[Message]
    places: list[tuple[int, int]]  # [B] begin and end of each message record; none in chunks


def messages():
    for k in range(COUNT):
        data = random.Random(k).randbytes(12 + 7 * (k % 11))
        yield Message(SOURCES[k % 3], data, NOW + k * 10**6, k // 3 + 1)


def record(folder, *, close, chunked):
    path = folder / "session.mcap"
    writer = (SessionWriter if chunked else UnchunkedWriter)(path)
    writer.add_metadata("session", {"seed": "7"})
    places = []
    for k, message in enumerate(messages()):
        writer.add(message)
        size = 9 + 22 + len(message.data)  # head, fields and data; channel and schema come before
        places.append((writer._stream.tell() - size, writer._stream.tell()))
        if k % 4 == 3:
            writer.commit()
    writer.add_metadata("parameters", {"gain": "1"})
    writer.commit()
    if close:
        writer.close()
    else:
        writer.abandon()
    content = path.read_bytes()
    if not chunked:
        for message, (begin, end) in zip(messages(), places, strict=True):
            assert content[begin] == 5 and content[begin + 31 : end] == message.data
    return Recording(content, list(messages()), [] if chunked else places)


@pytest.fixture(scope="module", autouse=True)
def no_wait_for_the_disk():
    """No power fails here: what is written need not be on the disk."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("os.fdatasync", lambda _: None)
        yield


@pytest.fixture(scope="module")
def recordings(tmp_path_factory):
    return {
        name: record(tmp_path_factory.mktemp(name), close=close, chunked=chunked)
        for name, close, chunked in (
            ("closed", True, False),
            ("killed", False, False),
            ("chunked", True, True),
            ("killed in chunks", False, True),
        )
    }


@st.composite
def damages(draw):
    """Ways to spoil a file, as functions of its bytes; places are fractions of its length."""
    kind = draw(st.sampled_from(["cut", "flip", "zero", "noise", "drop", "repeat", "insert"]))
    at = draw(st.floats(0.0, 1.0, exclude_max=True))
    length = draw(st.integers(1, 600))
    seed = draw(st.integers(0, 2**32))

    def spoil(content):
        k = int(at * len(content))
        if kind == "cut":
            return content[:k]
        if not content:
            return content
        if kind == "flip":
            changed = bytearray(content)
            changed[k] ^= 1 << seed % 8
            return bytes(changed)
        if kind == "drop":
            return content[:k] + content[k + length :]
        if kind == "repeat":
            return content[:k] + content[k : k + length] + content[k:]
        noise = bytes(length) if kind == "zero" else random.Random(seed).randbytes(length)
        if kind == "insert":
            return content[:k] + noise + content[k:]
        return content[:k] + noise[: len(content) - k] + content[k + length :]

    return spoil


def rescue(content, folder):
    """Recover a file; gives what was counted, the messages and the metadata of the copy."""
    (folder / "spoilt.mcap").write_bytes(content)
    result = recover(SessionReader(folder / "spoilt.mcap", tolerant=True), folder / "new.mcap")
    with (folder / "new.mcap").open("rb") as file:  # by the public library: the copy is sound
        reader = make_reader(file, validate_crcs=True)
        assert reader.get_summary().statistics.message_count == result.messages
    copy = SessionReader(folder / "new.mcap")
    found = list(copy.messages())
    assert len(found) == result.messages
    assert (copy.condition.is_closed, copy.condition.damage) == (True, [])
    return result, found, copy.condition.latest("recovered")


@pytest.mark.parametrize("name", ["closed", "killed", "chunked", "killed in chunks"])
@given(spoils=st.lists(damages(), min_size=1, max_size=4))
@settings(max_examples=EXAMPLES)
def test_no_damage_stops_recovery_or_goes_unsaid(recordings, tmp_path_factory, name, spoils):
    """No message is put together from pieces, or given twice."""
    content = recordings[name].content
    for spoil in spoils:
        content = spoil(content)
    result, found, account = rescue(content, tmp_path_factory.mktemp("spoilt"))
    condition = result.condition
    stretches = sorted((d.offset, d.offset + d.length) for d in condition.damage)
    assert all(end <= begin for (_, end), (begin, _) in pairwise([*stretches, (len(content),) * 2]))
    assert account["messages"] == str(len(found))
    assert account["was_closed"] == str(condition.is_closed)
    if found != recordings[name].messages:
        is_said = condition.damage or not condition.is_closed or result.missing
        assert is_said or condition.checksum == "wrong"
    if recordings[name].places:  # no chunk packs its messages: each stands in it byte for byte
        for message, count in Counter(m.data for m in found).items():
            assert content.count(message) >= count


def second(opcode, content):
    """Where the second record of an opcode begins [B]; the first chunk names the topics."""
    at, places = len(MAGIC), []
    while len(places) < 2:
        found, length = HEAD.unpack_from(content, at)
        places += [at] if found == opcode else []
        at += HEAD.size + length
    return places[-1]


@pytest.mark.parametrize("name", ["chunked", "killed in chunks"])
@pytest.mark.parametrize("opcode", [k for k in range(1, 16) if k != CHUNK])
def test_a_chunk_that_wrong_bits_make_another_record_is_named_and_hides_nothing_after_it(
    recordings, tmp_path, name, opcode
):
    content = bytearray(recordings[name].content)
    content[second(CHUNK, content)] = opcode
    result, found, _ = rescue(bytes(content), tmp_path)
    assert COUNT / 2 < len(found) < COUNT and len(result.condition.damage) == 1


@pytest.mark.parametrize("name", ["chunked", "killed in chunks"])
@pytest.mark.parametrize("bit", range(8))
def test_no_wrong_bit_makes_a_message_of_an_index(recordings, tmp_path, name, bit):
    content = bytearray(recordings[name].content)
    content[second(MESSAGE_INDEX, content)] ^= 1 << bit
    result, found, _ = rescue(bytes(content), tmp_path)
    assert found == recordings[name].messages and len(result.condition.damage) == 1


def test_an_ending_whose_begin_is_damaged_is_no_loss_of_its_own(recordings, tmp_path):
    content = bytearray(recordings["chunked"].content)
    at = content.rindex(HEAD.pack(DATA_END, 4))
    content[at] ^= 1  # a summary offset
    result, found, _ = rescue(bytes(content), tmp_path)
    (damage,) = result.condition.damage
    assert found == recordings["chunked"].messages and damage.offset == at


@pytest.mark.parametrize("name", ["closed", "killed"])
@given(data=st.data())
@settings(max_examples=EXAMPLES)
def test_after_damage_in_place_only_what_was_recorded_is_read(
    recordings, tmp_path_factory, name, data
):
    """Flips and zeroed blocks take messages away; what is left is as it was, in its order.

    A killed recording names its topics once, in its first commit, and its end has no checksum. A
    closed one has them twice, so that one place of damage is never the only one.
    """
    recording = recordings[name]
    content = bytearray(recording.content)
    first, last, most = 0, len(content) - 1, 1
    if name == "killed":
        first, last, most = recording.places[4][0], recording.places[-9][0], 5
    for _ in range(data.draw(st.integers(1, most))):
        at, length = data.draw(st.integers(first, last)), data.draw(st.integers(1, 300))
        if data.draw(st.booleans()):
            content[at] ^= 1 << length % 8
        else:
            length = min(length, last + 1 - at)
            content[at : at + length] = bytes(length)
    _, found, _ = rescue(bytes(content), tmp_path_factory.mktemp("spoilt"))
    left = iter(recording.messages)
    for message in found:
        assert message in left


@pytest.mark.parametrize("cut", range(0, 40, 3))
def test_the_shortest_files_are_recovered_too(recordings, tmp_path, cut):
    result, found, _ = rescue(recordings["closed"].content[:cut], tmp_path)
    assert found == [] and not result.condition.is_closed


def test_lengths_that_lie_cost_neither_memory_nor_messages(recordings, tmp_path):
    """A record, and a chunk, that claim more than there is."""
    recording = recordings["closed"]
    content = bytearray(recording.content)
    begin, _ = recording.places[10]
    content[begin + 1 : begin + 9] = struct.pack("<Q", 2**31 - 5)
    _, found, _ = rescue(bytes(content), tmp_path)
    assert [m for m in recording.messages if m not in found] == recording.messages[8:12]


@pytest.mark.parametrize("name", ["closed", "killed"])
def test_one_bit_of_a_payload_costs_its_commit_alone_and_is_reported(recordings, tmp_path, name):
    recording = recordings[name]
    content = bytearray(recording.content)
    content[recording.places[41][1] - 1] ^= 1
    result, found, account = rescue(bytes(content), tmp_path)
    assert found == recording.messages[:40] + recording.messages[44:]
    (damage,) = result.condition.damage
    assert damage.what == "changed since it was written: 4 records left out"
    assert recording.places[39][1] < damage.offset <= recording.places[40][0]
    assert result.missing == 4 and int(account["unreadable_bytes"]) == damage.length

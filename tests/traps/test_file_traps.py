# SPDX-License-Identifier: BSD-3-Clause
"""Files as other programs write them: sound, recordings, settings, robots, texts of silence."""

import shutil
import struct

import numpy as np
import pytest
import soundfile
from mcap.reader import make_reader

from session_log.mcap_file.writer import SessionWriter
from session_log.types import Message, MessageSource
from typed_config import package_folder
from voice_assist.audio.sound_file import read_sound
from voice_assist.config import load_voice_config
from voice_assist.errors import AudioError
from voice_assist.intent.mapper import Mapper
from voice_assist.types import NoMatch

RATE = 16_000
UNKNOWN = 0xFFFFFFFF  # the size that a program writes which streams and cannot go back
TONE = (0.3 * np.sin(np.arange(RATE // 2) * 0.2) * 32767).astype("<i2").tobytes()
BEGIN = 1_795_200_000 * 10**9  # [ns]
STRING = MessageSource(
    "/t", "std_msgs/String", "992ce8a1687cec8c8bd883ec73ca41d1", "string data", "/w"
)
EMPTY = MessageSource("/e", "std_msgs/Empty", "d41d8cd98f00b204e9800998ecf8427e", "", "/w")


def wav(data=TONE, extra=b"", size=None, rate=RATE):
    """Bytes of a WAV file with chunks before its data, and a size that need not be right."""
    size = len(data) if size is None else size
    form = struct.pack("<IHHIIHH", 16, 1, 1, rate, rate * 2, 2, 16)
    body = b"WAVEfmt " + form + extra + b"data" + struct.pack("<I", size) + data
    return b"RIFF" + struct.pack("<I", min(size, len(body))) + body


@pytest.mark.parametrize(
    "content",
    [
        wav(size=UNKNOWN),
        wav(extra=b"LIST" + struct.pack("<I", 4) + b"INFO"),
        wav(extra=b"note" + struct.pack("<I", 3) + b"abc\0"),
        wav() + b"JUNK" * 100,
    ],
    ids=["streamed", "list chunk", "odd chunk", "junk behind"],
)
def test_a_wav_of_another_program_is_heard_whole(tmp_path, content):
    (tmp_path / "s.wav").write_bytes(content)
    assert len(read_sound(tmp_path / "s.wav")) == RATE // 2


@pytest.mark.parametrize(
    "content",
    [b"", TONE, wav(size=0), wav(rate=0), b"<!DOCTYPE html><html>404", wav(b"")],
    ids=["empty", "no header", "size zero", "rate zero", "web page", "no sound"],
)
def test_what_is_no_sound_is_named(tmp_path, content):
    (tmp_path / "s.wav").write_bytes(content)
    with pytest.raises(AudioError, match=r"s\.wav"):
        read_sound(tmp_path / "s.wav")


def test_a_folder_in_the_place_of_a_sound_is_not_said_to_be_missing(tmp_path):
    with pytest.raises(AudioError, match=r": not a file$"):
        read_sound(tmp_path)


@pytest.mark.parametrize("rate", [8000, 11025, 44100, 48000, 96000, 192000])
def test_a_headset_of_any_rate_gives_the_same_length(tmp_path, rate):
    soundfile.write(tmp_path / "s.wav", 0.1 * np.sin(np.arange(rate) * 0.1), rate)
    assert abs(len(read_sound(tmp_path / "s.wav")) - RATE) <= 1


SILENCE = [
    "Thank you.",
    "Thanks for watching!",
    "you",
    "Bye.",
    "So",
    "Oh",
    "okay",
    "I'm sorry",
    ".",
    "...",
    "♪ ♪",
    "[BLANK_AUDIO]",
    "(music)",
    "*applause*",
    "Please subscribe",
    "Subtitles by the Amara.org community",
    "Transcription by CastingWords",
    "www.mooji.org",
    "1.5%",
    "ご視聴ありがとうございました",
]


@pytest.mark.parametrize("text", SILENCE)
def test_what_whisper_writes_for_silence_is_no_command(text):
    assert isinstance(Mapper(load_voice_config().commands)(text), NoMatch)


def recorded(path, *messages):
    """A recording of (source, text, time after the begin); its messages by its index."""
    with SessionWriter(path) as writer:
        for k, (source, text, after) in enumerate(messages):
            data = len(text).to_bytes(4, "little") + text if source is STRING else b""
            writer.add(Message(source, data, BEGIN + after, k + 1))

    def times(**limits):
        with path.open("rb") as file:
            reader = make_reader(file, validate_crcs=True)
            return [m.log_time - BEGIN for _, _, m in reader.iter_messages(**limits)]

    return times


def test_a_message_larger_than_a_chunk_is_in_the_index(tmp_path):
    times = recorded(
        tmp_path / "s.mcap", (STRING, b"a", 0), (STRING, b"x" * 6_000_000, 1), (STRING, b"b", 2)
    )
    assert times() == [0, 1, 2]


def test_the_last_message_of_a_chunk_is_found_from_its_own_time(tmp_path):
    times = recorded(tmp_path / "s.mcap", *((STRING, b"x" * 2_000_000, k) for k in range(5)))
    assert [times(start_time=BEGIN + k)[0] for k in range(5)] == list(range(5))
    assert times(end_time=BEGIN + 4) == [0, 1, 2, 3]


def test_a_type_without_fields_is_recorded_as_any_other(tmp_path):
    assert recorded(tmp_path / "s.mcap", (EMPTY, b"", 0), (EMPTY, b"", 1))() == [0, 1]


def test_messages_out_of_order_come_in_order(tmp_path):
    assert recorded(tmp_path / "s.mcap", (STRING, b"b", 5), (STRING, b"a", 1))() == [1, 5]


@pytest.fixture
def settings(tmp_path):
    """Loads the voice's settings with one file's bytes changed."""

    def load(change):
        folder = tmp_path / "config"
        shutil.copytree(package_folder("voice_assist") / "config", folder)
        file = folder / "speaker.yaml"
        file.write_bytes(change(file.read_bytes()))
        return load_voice_config(folder).speaker

    return load


@pytest.mark.parametrize(
    "change",
    [lambda text: b"\xef\xbb\xbf" + text, lambda text: text.replace(b"\n", b"\r\n")],
    ids=["byte order mark", "lines of Windows"],
)
def test_settings_of_an_editor_of_windows_are_read(settings, change):
    assert settings(change) == load_voice_config().speaker

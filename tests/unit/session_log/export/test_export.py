# SPDX-License-Identifier: BSD-3-Clause
import wave

import pytest

from session_log.export.export import ParquetMissing, export_topics
from support.story import Story, recording_of


def test_lost_sound_becomes_silence_of_the_same_length(tmp_path):
    story = Story()
    for first, value in ((0, 100), (512, 200), (2048, 300)):
        story.say(
            first / 16000,
            "/a",
            "voice_assist/AudioChunk",
            rate=16000,
            first_sample=first,
            samples=[value] * 512,
        )
    session = recording_of(tmp_path / "s.mcap", story.messages)
    result = export_topics(session, tmp_path / "out", [], "/a")
    assert (result.samples, result.lost_samples) == (1536, 1024)
    with wave.open(str(result.sound)) as sound:
        content = sound.readframes(sound.getnframes())
    values = [int.from_bytes(content[i : i + 2], "little") for i in range(0, len(content), 2)]
    assert values == [100] * 512 + [200] * 512 + [0] * 1024 + [300] * 512


def test_parquet_without_pyarrow_says_what_to_install_and_writes_nothing(monkeypatch, tmp_path):
    monkeypatch.setattr("session_log.export.export.find_spec", lambda name: None)
    reader = recording_of(tmp_path / "s.mcap")
    with pytest.raises(ParquetMissing, match=r"requirements-parquet\.txt.*--format csv"):
        export_topics(reader, tmp_path / "out", [], "/a", ("csv", "parquet"))
    assert not (tmp_path / "out").exists()

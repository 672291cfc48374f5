# SPDX-License-Identifier: BSD-3-Clause
import pytest
from mcap.reader import make_reader

from session_log.errors import OutputFailed
from session_log.mcap_file.reader import SessionReader
from session_log.mcap_file.recover import recover


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
    account = SessionReader(tmp_path / "new.mcap").check().latest("recovered")
    assert account["from"] == "cut.mcap" and account["was_closed"] == "False"
    assert SessionReader(tmp_path / "new.mcap").check().latest("session")["seed"] == "7"


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

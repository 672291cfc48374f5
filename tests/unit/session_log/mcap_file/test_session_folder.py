# SPDX-License-Identifier: BSD-3-Clause
import logging
import os
from pathlib import Path

import pytest

from session_log.config import RecorderConfig
from session_log.errors import RecordingFailed, SessionMissing
from session_log.mcap_file import session_folder
from session_log.mcap_file.reader import SessionReader
from session_log.mcap_file.recover import recover
from session_log.mcap_file.session_folder import (
    open_session,
    recordings,
    report_folder,
    session_name,
    sessions_folder,
)
from session_log.types import Message, MessageSource
from typed_config import ConfigError, load_config

NOW = 1_795_200_000_000_000_000
SOURCE = MessageSource("/t", "std_msgs/String", "992c", "string data", "/p")
ROOT = Path(__file__).resolve().parents[4]


def test_a_named_folder_counts():
    assert sessions_folder("/data/sessions") == Path("/data/sessions")
    assert sessions_folder("~/x") == Path.home() / "x"


@pytest.mark.parametrize("folder", ["sessions", "./x", "~nobody_of_that_name/x"])
def test_a_folder_without_its_whole_path_is_refused_by_name(recorder_settings, folder):
    """roslaunch runs a node in $ROS_HOME: there nobody looks for it."""
    with pytest.raises(ConfigError, match=f"{folder}.*a whole path, or one that begins with ~"):
        load_config(RecorderConfig, {**recorder_settings, "folder": folder}, "recorder.yaml")


@pytest.mark.parametrize("folder", ["", "/data/sessions", "~", "~/x"])
def test_a_whole_path_or_one_from_home_is_allowed(recorder_settings, folder):
    settings = {**recorder_settings, "folder": folder}
    assert load_config(RecorderConfig, settings, "recorder.yaml").folder == folder


def test_without_a_name_recordings_go_to_the_repository():
    assert sessions_folder("") == ROOT / "sessions"


def test_without_a_name_those_of_an_install_space_go_to_the_home_folder(monkeypatch, tmp_path):
    monkeypatch.setattr(session_folder, "repository", lambda package: None)
    monkeypatch.setenv("HOME", str(tmp_path))
    assert sessions_folder("") == tmp_path / "sessions"


def record(folder, text):
    with open_session(folder, "pivot", NOW) as writer:
        writer.add(Message(SOURCE, text, NOW, 1))
    return writer.path


def test_of_two_recordings_of_one_name_the_newest_is_read_and_it_is_said(tmp_path, caplog):
    first = record(tmp_path, b"first")
    with caplog.at_level(logging.WARNING):
        assert [m.data for m in SessionReader(first.parent).messages()] == [b"first"]
        assert not caplog.messages
        second = record(tmp_path, b"second")
        (first.parent / "session_2_recovered.mcap").write_bytes(b"a copy is none")
        assert [m.data for m in SessionReader(first.parent).messages()] == [b"second"]
    assert caplog.messages == [f"{second}: the newest of 2 recordings in this folder"]
    assert [m.data for m in SessionReader(first).messages()] == [b"first"]  # by its own name


def test_a_number_that_became_free_is_not_taken_again(tmp_path):
    paths = [record(tmp_path, b"%d" % k) for k in range(11)]
    assert [p.name for p in paths[:3]] == ["session.mcap", "session_2.mcap", "session_3.mcap"]
    paths[0].unlink()
    paths[4].unlink()
    record(tmp_path, b"newest")  # session_12.mcap comes after session_9.mcap
    assert [m.data for m in SessionReader(paths[0].parent).messages()] == [b"newest"]


def test_a_folder_that_cannot_be_listed_is_no_place_for_a_recording(tmp_path, monkeypatch):
    def unreadable(folder):
        raise PermissionError(13, "Permission denied", str(folder))

    monkeypatch.setattr(session_folder, "numbered_recordings", unreadable)
    with pytest.raises(RecordingFailed, match="Permission denied"):
        record(tmp_path, b"x")


def test_recordings_of_one_folder_have_names_and_reports_of_their_own(tmp_path):
    first, second = record(tmp_path, b"1"), record(tmp_path, b"2")
    assert (session_name(first), session_name(second)) == ("pivot", "pivot (2)")
    assert report_folder(first) == first.parent
    assert report_folder(second) == first.parent / "session_2"


def test_a_recovered_copy_has_a_report_of_its_own_beside_its_original(tmp_path):
    copy = tmp_path / "session_recovered.mcap"
    copy.write_bytes(b"a copy")
    assert report_folder(copy) == tmp_path  # alone
    (tmp_path / "session.mcap").write_bytes(b"the original")
    assert report_folder(copy) == tmp_path / "session_recovered"
    assert report_folder(tmp_path / "session.mcap") == tmp_path


def test_a_report_lies_beside_its_recording_whatever_lies_in_folders_below(tmp_path, monkeypatch):
    """A recording may lie in a home folder: to search all of it takes long."""
    (tmp_path / "bag.mcap").write_bytes(b"alone here")
    (tmp_path / "below").mkdir()
    (tmp_path / "below" / "other.mcap").write_bytes(b"elsewhere")
    monkeypatch.setattr(session_folder.os, "walk", pytest.fail)
    assert report_folder(tmp_path / "bag.mcap") == tmp_path
    (tmp_path / "other.mcap").write_bytes(b"beside it")
    assert report_folder(tmp_path / "bag.mcap") == tmp_path / "bag"


def test_a_recording_of_any_other_ending_has_a_place_for_its_report(tmp_path):
    (tmp_path / "session.mcap.old").write_bytes(b"alone")
    assert report_folder(tmp_path / "session.mcap.old") == tmp_path


def test_recordings_are_found_in_and_below_a_folder_each_once(tmp_path):
    paths = [record(tmp_path / "b", b"1"), record(tmp_path, b"2")]
    (tmp_path / "notes.txt").write_text("no recording", encoding="utf-8")
    assert recordings([tmp_path, paths[0]]) == sorted(paths)


def test_recordings_of_linked_folders_are_found_and_a_link_that_leads_back_ends(tmp_path):
    sessions, disk = tmp_path / "sessions", tmp_path / "disk"
    record(disk / "old", b"1")
    sessions.mkdir()
    (sessions / "linked").symlink_to(disk)
    (disk / "back").symlink_to(sessions)
    assert recordings([sessions]) == [sessions / "linked" / "old" / "pivot" / "session.mcap"]


def test_a_folder_below_that_cannot_be_read_is_refused_by_name(tmp_path, monkeypatch):
    """Its sessions would be missing from the report, and nobody would be told."""
    record(tmp_path, b"readable")
    closed, scan = tmp_path / "closed", os.scandir
    closed.mkdir()

    def refuse(path):
        if Path(path) == closed:
            raise PermissionError(13, "Permission denied", str(path))
        return scan(path)

    monkeypatch.setattr(os, "scandir", refuse)
    with pytest.raises(SessionMissing, match=r"/closed: Permission denied$"):
        recordings([tmp_path])


def recovered(original, bit=0):
    """The copy of a recording of which then one bit is wrong; None: no bit of it."""
    copy = original.with_stem(original.stem + "_recovered")
    recover(SessionReader(original, tolerant=True), copy)
    if bit is not None:
        content = bytearray(original.read_bytes())
        content[bit // 8] ^= 1 << bit % 8
        original.write_bytes(content)
    return copy


@pytest.mark.parametrize("bit", [0, 63])
def test_a_recovered_copy_counts_where_its_original_has_a_damaged_beginning(tmp_path, bit):
    original = record(tmp_path / "damaged", b"1")
    copy = recovered(original, bit)
    sound = record(tmp_path / "sound", b"2")
    recovered(sound, None)
    assert recordings([tmp_path]) == [copy, sound]
    assert recordings([tmp_path, original]) == [copy, sound, original]  # by its own name
    assert report_folder(copy) == copy.with_suffix("")
    assert report_folder(original) == original.parent


def test_of_a_damaged_copy_its_own_copy_counts(tmp_path):
    first = recovered(record(tmp_path, b"1"))
    second = recovered(first)
    assert recordings([tmp_path]) == [second]
    assert len({report_folder(p) for p in second.parent.glob("*.mcap")}) == 3


def test_a_damaged_beginning_without_a_copy_is_found(tmp_path):
    """Else nobody would be told that it cannot be read."""
    original = record(tmp_path, b"1")
    recovered(original).unlink()
    assert recordings([tmp_path]) == [original]


def test_the_place_of_a_report_does_not_change_where_a_beginning_is_damaged(tmp_path):
    path = tmp_path / "bag.mcap"
    path.write_bytes(record(tmp_path / "of", b"1").read_bytes())
    copy = recovered(path, None)
    places = [report_folder(path), report_folder(copy)]
    assert places == [tmp_path, tmp_path / "bag_recovered"]
    path.write_bytes(b"damaged")
    assert [report_folder(path), report_folder(copy)] == places

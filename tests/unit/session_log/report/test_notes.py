# SPDX-License-Identifier: BSD-3-Clause
"""Notes beside a recording."""

import shutil

import pytest

from session_log.cli import main
from session_log.report.notes import Note, add_note, notes_file, read_notes


def test_notes_are_lines_of_a_file_that_people_may_edit(tmp_path):
    recording = tmp_path / "session_2.mcap"
    assert read_notes(recording) == ()
    add_note(recording, Note("all of it\nin two lines"))
    add_note(recording, Note("a moment", 12.25))
    assert notes_file(recording).read_text("utf-8") == "all of it in two lines\n12.25 s: a moment\n"
    with notes_file(recording).open("a", encoding="utf-8") as file:
        file.write("\n  12 s after the cough\n")
    assert read_notes(recording) == (
        Note("all of it in two lines"),
        Note("a moment", 12.25),
        Note("12 s after the cough"),
    )


@pytest.mark.parametrize("old", ["calibrated", "calibrated\n", "calibrated\r\n"])
def test_a_note_begins_a_line_of_its_own_behind_one_that_has_no_end(tmp_path, old):
    recording = tmp_path / "session.mcap"
    notes_file(recording).write_bytes(old.encode())
    add_note(recording, Note("cough", 12.0))
    assert read_notes(recording) == (Note("calibrated"), Note("cough", 12.0))
    assert notes_file(recording).read_bytes().count(b"\n") == 2


@pytest.fixture
def noted(story, tmp_path, capsys):
    """Writes a note on the story, or on the first bytes of it; gives status and what is said."""

    def run(*words, size=None):
        recording = shutil.copy(story[0], tmp_path / "session.mcap")
        recording.write_bytes(recording.read_bytes()[:size])
        with pytest.raises(SystemExit) as ended:
            main(["note", str(recording), *words])
        return ended.value.code, capsys.readouterr().err, read_notes(recording)

    return run


def test_a_moment_after_the_end_is_refused_with_the_length(noted):
    code, error, notes = noted("a cough", "--at", "48")
    assert (code, notes) == (1, ())
    assert error == (
        "session_log: --at is 48.0, allowed: 0 to 47.0 s, the length of the recording\n"
    )
    assert noted("a cough", "--at", "47") == (0, "", (Note("a cough", 47.0),))


def test_a_recording_that_was_not_closed_may_go_on(noted):
    assert noted("a cough", "--at", "48", size=-5000) == (0, "", (Note("a cough", 48.0),))


@pytest.mark.parametrize("words", [[""], [" ", "\n"]])
def test_an_empty_note_is_refused(noted, words):
    assert noted(*words) == (1, "session_log: the note is empty; nothing was written\n", ())

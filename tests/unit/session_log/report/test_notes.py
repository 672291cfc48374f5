# SPDX-License-Identifier: BSD-3-Clause
"""Notes beside a recording."""

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


@pytest.mark.parametrize("moment", ["-1", "nan", "soon"])
def test_a_moment_that_is_none_is_refused(story, moment, capsys):
    with pytest.raises(SystemExit) as ended:
        main(["note", str(story[0]), "a", "cough", "--at", moment])
    assert ended.value.code == 2 and "--at" in capsys.readouterr().err

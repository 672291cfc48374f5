# SPDX-License-Identifier: BSD-3-Clause
import re

import pytest

from session_log.errors import RecordingFailed
from session_log.mcap_file.session_folder import open_session

NOW = 1_795_200_000_000_000_000


def test_a_session_is_named_after_its_time(tmp_path):
    with open_session(tmp_path / "sessions", "", NOW) as writer:
        folder = writer.path.parent
    assert re.fullmatch(r"2026-11-\d\dT\d\d-\d\d-\d\d", folder.name)
    assert writer.path.name == "session.mcap"


def test_an_earlier_recording_is_kept(tmp_path):
    names = []
    for _ in range(3):
        with open_session(tmp_path, "demo", NOW) as writer:
            names.append(writer.path.name)
    assert names == ["session.mcap", "session_2.mcap", "session_3.mcap"]


def test_the_folder_itself_may_be_the_sessions(tmp_path):
    with open_session(tmp_path, ".", NOW) as writer:
        assert writer.path == tmp_path / "session.mcap"


def test_a_folder_that_cannot_be_made_is_named(tmp_path):
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(RecordingFailed, match=r"file/x/session\.mcap: Not a directory"):
        open_session(tmp_path / "file", "x", NOW)

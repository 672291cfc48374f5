# SPDX-License-Identifier: BSD-3-Clause
from pathlib import Path

from session_log.mcap_file import session_folder
from session_log.mcap_file.session_folder import sessions_folder

ROOT = Path(__file__).resolve().parents[4]


def test_a_named_folder_counts():
    assert sessions_folder("/data/sessions") == Path("/data/sessions")
    assert sessions_folder("~/x") == Path.home() / "x"


def test_without_a_name_recordings_go_to_the_repository():
    assert sessions_folder("") == ROOT / "sessions"


def test_without_a_name_those_of_an_install_space_go_to_the_home_folder(monkeypatch, tmp_path):
    monkeypatch.setattr(session_folder, "repository", lambda package: None)
    monkeypatch.setenv("HOME", str(tmp_path))
    assert sessions_folder("") == tmp_path / "sessions"

# SPDX-License-Identifier: BSD-3-Clause
"""Where reports go: folders that take none, and names that are no UTF-8."""

import os
from pathlib import Path

import pytest

from session_log.errors import OutputFailed
from session_log.mcap_file.reader import SessionReader
from session_log.report import many_sessions, one_session
from session_log.report.many_sessions import write_folder_report
from session_log.report.one_session import write_report
from session_log.report.pool.parallel import Unfinished
from support.story import recording_of

pytestmark = pytest.mark.usefixtures("without_figures")


@pytest.fixture
def session(tmp_path):
    """A recording in a folder of its own."""
    (tmp_path / "one").mkdir()
    return recording_of(tmp_path / "one" / "session.mcap").path


def test_a_folder_that_takes_no_page_is_refused_before_a_session_is_read(
    session, tmp_path, report_config, monkeypatch
):
    monkeypatch.setattr(one_session, "_read", lambda *_: pytest.fail("it was read"))
    (tmp_path / "file").write_text("in the way")
    words = r"cannot write .*file: Not a directory; --out DIR writes elsewhere"
    with pytest.raises(OutputFailed, match=words):
        write_report(SessionReader(session), tmp_path / "file", report_config)
    with pytest.raises(OutputFailed, match=words):
        write_folder_report([session.parent], tmp_path / "file", report_config)


def test_a_session_whose_page_cannot_be_written_counts_and_is_named(
    session, tmp_path, report_config, caplog
):
    (session.parent / "report.html").mkdir()
    report = write_folder_report([tmp_path], tmp_path, report_config, beside=True)
    assert (report.sessions, report.unread, report.unwritten) == (1, (), 1)
    (said,) = caplog.messages
    assert said.startswith(f"{session}: read and counted, but cannot write {session.parent}: ")
    assert said.endswith("; --out DIR writes elsewhere")


def test_a_session_whose_worker_was_killed_is_named_as_not_read(
    session, tmp_path, report_config, monkeypatch
):
    recording_of(tmp_path / "b.mcap")

    def run(work, tasks, jobs, cluster):
        return [work(tasks[0]), Unfinished(tasks[1], "KilledWorker: 4 died")]

    monkeypatch.setattr(many_sessions, "run_parallel", run)
    report = write_folder_report([tmp_path], tmp_path / "o", report_config, with_pages=False)
    assert report.sessions == 1
    (lost,) = report.unread
    assert lost.path in (session, tmp_path / "b.mcap") and lost.reason == "KilledWorker: 4 died"


def test_names_that_are_no_utf_8_end_no_report(tmp_path, report_config):
    folder = Path(os.fsdecode(os.fsencode(tmp_path) + b"/caf\xe9"))
    folder.mkdir()
    reader = recording_of(folder / "session.mcap")
    page = write_report(reader, tmp_path / "o", report_config).page
    assert "Session caf\\udce9" in page.read_text("utf-8")
    page = write_folder_report([folder], tmp_path / "p", report_config, with_pages=False).page
    assert "caf\\udce9" in page.read_text("utf-8")

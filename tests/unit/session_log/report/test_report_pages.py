# SPDX-License-Identifier: BSD-3-Clause
"""The page of a session in a folder: made anew where settings or notes are other ones."""

from dataclasses import replace

import pytest

from session_log.mcap_file.reader import SessionReader
from session_log.mcap_file.recover import recover
from session_log.report import one_session
from session_log.report.many_sessions import write_folder_report
from session_log.report.notes import Note, add_note
from session_log.report.one_session import write_report
from support.story import write_session

pytestmark = pytest.mark.usefixtures("without_figures")


@pytest.fixture
def session(tmp_path):
    path = tmp_path / "many" / "a" / "session.mcap"
    write_session(path, duration=6.0, rate=20)
    return path


def page_of(session):
    return session.with_name("report.html").read_text("utf-8")


def report_many(session, config, **options):
    top = session.parents[1]
    write_folder_report([top], top, config, beside=True, **options)
    return page_of(session) if session.with_name("report.html").exists() else ""


def test_a_page_with_voices_does_not_stay_where_none_are_wanted(session, report_config):
    silent = replace(report_config, utterance_sound=False)
    report_many(session, silent, with_pages=False)  # its summary is known already
    write_report(SessionReader(session), session.parent, report_config)
    assert "data:audio" in page_of(session)
    assert "data:audio" not in report_many(session, silent)
    assert "data:audio" in report_many(session, report_config)


def test_a_page_is_kept_apart_from_the_page_over_all_in_the_same_folder(session, report_config):
    top = session.parents[1]
    bag = session.rename(top / "bag.mcap")
    report = write_folder_report([top], top, report_config, beside=True)
    assert report.page == top / "report.html"
    assert 'href="bag/report.html"' in report.page.read_text("utf-8")
    assert "Session bag" in (bag.with_suffix("") / "report.html").read_text("utf-8")


def test_a_note_comes_onto_the_page_though_its_summary_is_newer(session, report_config):
    assert "a cough" not in report_many(session, report_config)
    add_note(session, Note("a cough"))
    assert "a cough" not in report_many(session, report_config, with_pages=False)
    assert "a cough" in report_many(session, report_config)


def test_a_page_that_is_still_true_is_not_made_again(session, report_config, monkeypatch):
    write_report(SessionReader(session), session.parent, report_config)
    text = report_many(session, report_config)  # makes the summary
    with monkeypatch.context() as closed:
        closed.setattr(one_session, "SessionReader", pytest.fail)
        assert report_many(session, report_config) == text
    session.with_name("report.html").write_text("cut off", "utf-8")
    assert report_many(session, report_config) == text


def test_the_page_of_a_copy_warns_of_what_its_original_had_lost(session, report_config):
    cut = session.with_name("cut.mcap")
    cut.write_bytes(session.read_bytes()[:-5000])
    session.unlink()
    recover(SessionReader(cut), session)
    write_report(SessionReader(session), session.parent, report_config)
    assert "Copied from cut.mcap, which was not closed" in page_of(session)

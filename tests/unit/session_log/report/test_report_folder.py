# SPDX-License-Identifier: BSD-3-Clause
"""The report over a folder of recordings, some of which cannot be read."""

import json
import os
import re
import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from session_log.mcap_file.session_folder import recordings
from session_log.report import many_sessions, one_session
from session_log.report.many_sessions import write_folder_report
from session_log.report.notes import Note, add_note
from session_log.report.pool.parallel import EngineMissing, EngineUnreachable, run_parallel
from support.story import Story, recording_of, write_session
from tests.unit.session_log.report.test_report import Page


@pytest.fixture(scope="module")
def source(tmp_path_factory):
    """Two whole sessions, a killed one, a file that is none, and a recovered copy; no audio."""
    top = tmp_path_factory.mktemp("sessions")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Story, "audio", lambda _: None)
        for k in range(2):
            write_session(top / f"day {k}" / "session.mcap", rate=20, seed=k)
    whole = (top / "day 0" / "session.mcap").read_bytes()
    (top / "killed").mkdir()
    (top / "killed" / "session.mcap").write_bytes(whole[: len(whole) // 2])
    (top / "odd").mkdir()
    (top / "odd" / "bag.mcap").write_bytes(b"#ROSBAG V2.0")
    shutil.copy(top / "day 1" / "session.mcap", top / "day 1" / "session_recovered.mcap")
    return top


@pytest.fixture
def sessions(source, tmp_path):
    return Path(shutil.copytree(source, tmp_path / "sessions"))


@pytest.fixture
def pooled(sessions, tmp_path, report_config):
    """The report over the sessions, without their pages."""

    def write(folder=sessions, out="out", config=report_config, **ways):
        return write_folder_report([folder], tmp_path / out, config, with_pages=False, **ways)

    return write


def test_readable_sessions_are_pooled_and_the_others_named(pooled):
    report = pooled()
    assert report.sessions == 3
    assert [u.path.name for u in report.unread] == ["bag.mcap"]
    page = Page(report)
    rows = {row[0]: row[1:] for row in page.rows if len(row) == 5}
    assert rows["hey robot"][:2] == ["5", "5"] and rows["stop"][0] == "4"  # one is cut in half
    named = next(row for row in page.rows if len(row) == 2 and "bag.mcap" in row[0])
    assert "is not an MCAP recording" in named[1]
    assert "One recording is not readable" in page.words
    assert {path.stem for path in report.figures} == {"accuracy", "confusion", "latency"}


@pytest.mark.usefixtures("without_figures")
def test_every_session_has_a_page_that_its_row_leads_to(sessions, report_config):
    shutil.rmtree(sessions / "day 1")
    report = write_folder_report([sessions], sessions, report_config, beside=True)
    links = re.findall(r'<a href="([^"]+)"', report.page.read_text(encoding="utf-8"))
    assert sorted(links) == ["day%200/report.html", "killed/report.html"]
    for name in ("day 0", "killed"):
        page = (sessions / name / "report.html").read_text(encoding="utf-8")
        assert f"Session {name}" in page and "Timeline" in page
    assert not (sessions / "odd" / "report.html").exists()


@pytest.mark.usefixtures("without_figures")
def test_pages_below_the_output_leave_the_recordings_alone(sessions, tmp_path, report_config):
    before = sorted(sessions.rglob("*"))
    report = write_folder_report([sessions / "killed"], tmp_path / "out", report_config)
    assert sorted(sessions.rglob("*")) == before
    (link,) = re.findall(r'<a href="([^"]+)"', report.page.read_text(encoding="utf-8"))
    assert link.startswith("sessions/killed_") and (tmp_path / "out" / link).is_file()


@pytest.mark.usefixtures("without_figures")
def test_a_session_is_read_again_only_when_it_changed(pooled, sessions, monkeypatch):
    opened = []
    reader = one_session.SessionReader
    monkeypatch.setattr(
        one_session, "SessionReader", lambda path: opened.append(path.parent.name) or reader(path)
    )

    text = Page(pooled()).text
    assert sorted(opened) == ["day 0", "day 1", "killed", "odd"]
    opened.clear()
    assert Page(pooled()).text == text
    assert opened == ["odd"]  # what could not be read is tried again
    opened.clear()
    os.utime(sessions / "day 1" / "session.mcap", ns=(1, 1))
    pooled()
    assert sorted(opened) == ["day 1", "odd"]


@pytest.mark.usefixtures("without_figures")
def test_other_settings_or_a_damaged_summary_are_no_reason_to_trust_it(
    pooled, sessions, tmp_path, report_config
):
    session = sessions / "day 0"
    pooled(session)
    kept = next((tmp_path / "out" / "sessions").glob("day 0*/report_summary.json"))
    values = json.loads(kept.read_text(encoding="utf-8"))
    values["summary"]["trials"] = "none"
    kept.write_text(json.dumps(values), encoding="utf-8")
    strict = replace(report_config, rcm_limit=20e-6)
    assert "samples above 20\u00a0µm" in Page(pooled(session, config=strict)).words
    kept.write_text("{", encoding="utf-8")
    assert pooled(session, config=strict).sessions == 1


@pytest.mark.usefixtures("without_figures")
def test_one_broken_session_does_not_end_the_others(pooled, monkeypatch):
    summarise = one_session.summarise

    def failing(name, *rest):
        if name == "day 0":
            raise ZeroDivisionError("in the middle")
        return summarise(name, *rest)

    monkeypatch.setattr(one_session, "summarise", failing)
    report = pooled()
    assert report.sessions == 2
    assert "ZeroDivisionError: in the middle" in {u.reason for u in report.unread}


def test_recordings_are_found_once_and_copies_left_out(sessions):
    found = recordings([sessions, sessions / "day 0" / "session.mcap"])
    assert [str(p.relative_to(sessions)) for p in found] == [
        "day 0/session.mcap",
        "day 1/session.mcap",
        "killed/session.mcap",
        "odd/bag.mcap",
    ]


def test_a_recovered_copy_without_its_original_counts(tmp_path):
    recording_of(tmp_path / "session_recovered.mcap")
    assert [p.name for p in recordings([tmp_path])] == ["session_recovered.mcap"]


def test_recovered_copies_that_are_named_count_beside_their_originals(tmp_path):
    for name in ("a", "a_recovered", "b", "b_recovered"):
        recording_of(tmp_path / f"{name}.mcap")
    copies = [tmp_path / "a_recovered.mcap", tmp_path / "b_recovered.mcap"]
    assert recordings(copies) == copies
    assert [p.stem for p in recordings([tmp_path])] == ["a", "b"]
    assert [p.stem for p in recordings([tmp_path, copies[1]])] == ["a", "b", "b_recovered"]


def test_names_of_sessions_in_different_folders_do_not_collide(source):
    names = {many_sessions._page_name(source / k / "session.mcap") for k in ("a/x", "b/x", "a/y")}
    assert len(names) == 3


def test_spreading_in_one_process_needs_no_engine(monkeypatch):
    monkeypatch.setattr(
        "session_log.report.pool.parallel.importlib.import_module", lambda name: pytest.fail(name)
    )
    assert list(run_parallel(abs, iter([-1, 2, -3]))) == [1, 2, 3]


def test_more_jobs_without_dask_say_what_to_install(monkeypatch):
    def missing(name):
        raise ImportError(name)

    monkeypatch.setattr("session_log.report.pool.parallel.importlib.import_module", missing)
    with pytest.raises(EngineMissing, match=r"requirements-bench\.txt"):
        list(run_parallel(abs, [1], jobs=2))


@pytest.mark.usefixtures("without_figures")
def test_no_more_processes_than_recordings_are_started(pooled, monkeypatch):
    started = []

    def run(work, tasks, jobs, cluster):
        started.append(jobs)
        return map(work, tasks)

    monkeypatch.setattr(many_sessions, "run_parallel", run)
    assert pooled(jobs=1_000_000).sessions == 3
    assert started == [4]


@pytest.mark.parametrize("address", ["127.0.0.1:1", "nonsense://x"])
def test_a_cluster_that_is_not_there_is_named(monkeypatch, address):
    pytest.importorskip("distributed")
    monkeypatch.setattr("session_log.report.pool.parallel.CONNECT_TIME", "200ms")
    with pytest.raises(EngineUnreachable, match=address):
        list(run_parallel(abs, [1], cluster=address))


@pytest.mark.usefixtures("without_figures")
def test_two_processes_and_a_cluster_find_what_one_process_finds(pooled):
    distributed = pytest.importorskip("distributed")
    reports = [pooled(out="one"), pooled(out="two", jobs=2)]
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None
    ) as cluster:
        reports.append(pooled(out="cluster", cluster=cluster.scheduler_address))
    assert [report.sessions for report in reports] == [3, 3, 3]
    assert len({Page(report).text for report in reports}) == 1


@pytest.mark.usefixtures("without_figures")
def test_a_session_is_found_by_what_was_heard_asked_refused_and_noted(pooled, sessions):
    add_note(sessions / "day 0" / "session.mcap", Note("Wrong trocar"))
    text = Page(pooled()).text
    words = dict(re.findall(r'data-words="([^"]*)".*?<span>(.*?)</span>', text))
    (noted,) = [heard for heard, name in words.items() if name == "day 0"]
    for phrase in ("could you pass me the clamp", "tense refused tissue is held", "Wrong trocar"):
        assert phrase in noted
    assert sum("Wrong trocar" in heard for heard in words) == 1
    assert '<input type="search"' in text


@pytest.mark.usefixtures("without_figures")
def test_a_session_whose_folder_was_renamed_has_its_new_name(tmp_path, report_config):
    (tmp_path / "first").mkdir()
    recording_of(tmp_path / "first" / "session.mcap")

    def names():
        write_folder_report([tmp_path], tmp_path, report_config, beside=True)
        text = (tmp_path / "report.html").read_text(encoding="utf-8")
        return re.findall(r'<a href="[^"]+">(?:<span>)?([^<]+)', text)

    assert names() == ["first"]
    (tmp_path / "first").rename(tmp_path / "second")
    assert names() == ["second"]
    page = (tmp_path / "second" / "report.html").read_text(encoding="utf-8")
    assert "Session second" in page and "Session first" not in page

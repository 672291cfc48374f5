# SPDX-License-Identifier: BSD-3-Clause
"""Sessions and settings that several tests share; no test changes them."""

import pytest

from session_log.cli import CONFIG
from session_log.config import RecorderConfig, ReportConfig
from session_log.mcap_file.reader import SessionReader
from session_log.report.session.extract import extract
from support.story import write_session
from typed_config import load_config, load_yaml


@pytest.fixture(autouse=True)
def no_wait_for_the_disk(monkeypatch):
    """No power fails here: what is written need not be on the disk."""
    monkeypatch.setattr("os.fdatasync", lambda _: None)


@pytest.fixture(scope="session")
def report_config():
    """The settings of report.yaml, with coarse figures: they are drawn many times here."""
    return load_config(ReportConfig, {**load_yaml(CONFIG), "resolution": 60}, "report.yaml")


@pytest.fixture
def without_figures(monkeypatch):
    """Reports have no figures, which take most of their time."""
    for name in ("one_session.POOL", "many_sessions.POOL", "one_session.SESSION"):
        monkeypatch.setattr(f"session_log.report.{name}_FIGURES", ())


@pytest.fixture
def with_timeline(without_figures, monkeypatch):
    """Reports have that one figure."""
    from session_log.report.figures import SESSION_FIGURES  # not by the many who draw nothing

    timeline = tuple(figure for figure in SESSION_FIGURES if figure.name == "timeline")
    monkeypatch.setattr("session_log.report.one_session.SESSION_FIGURES", timeline)


@pytest.fixture
def recorder_settings(tmp_path):
    """The settings of recorder.yaml as a mapping, with the folder of the test."""
    settings = dict(load_yaml(CONFIG.with_name("recorder.yaml")))
    return {**settings, "folder": str(tmp_path / "sessions")}


@pytest.fixture
def recorder_config(recorder_settings):
    return load_config(RecorderConfig, recorder_settings, "recorder.yaml")


@pytest.fixture(scope="session")
def story(tmp_path_factory):
    """A sound recording of a whole session at a tenth of the real rate, and its messages."""
    path = tmp_path_factory.mktemp("story") / "session.mcap"
    return path, write_session(path, rate=50)


@pytest.fixture(scope="session")
def data(story, report_config):
    """What a report takes from it."""
    return extract(SessionReader(story[0]), report_config)

# SPDX-License-Identifier: BSD-3-Clause

import os
from collections import Counter
from dataclasses import replace
from datetime import datetime
from pathlib import Path

import pytest

from session_log.mcap_file.condition import FileCondition
from session_log.mcap_file.summary import ClockStep, RecordingSummary
from session_log.report.folder_page import folder_page
from session_log.report.pool.pool import Pool
from session_log.report.session.session_data import SessionData
from session_log.report.session.shaft import rcm_from_joints
from session_log.report.session.summary import summarise
from session_log.report.tables.folder_tables import _link as link
from session_log.report.tables.folder_tables import sessions_table
from session_log.types import TopicCount
from support.story_script import START


@pytest.fixture
def pool_of(report_config, tmp_path):
    """A pool of one session with this data."""

    def of(data):
        summary = summarise("first", data, [], rcm_from_joints(data, report_config), report_config)
        pool = Pool(report_config)
        pool.add(tmp_path / "s.mcap", None, summary)
        return pool

    return of


@pytest.fixture
def row_of(pool_of, tmp_path):
    """The row of a session's data in the table over many."""
    return lambda data: sessions_table(pool_of(data), tmp_path).rows[0]


def closed(is_closed=True, **parts):
    return SessionData(RecordingSummary(FileCondition(is_closed=is_closed), **parts))


@pytest.mark.parametrize(("is_closed", "name"), [(True, "first"), (False, "first (incomplete)")])
def test_an_incomplete_recording_is_named_so(row_of, is_closed, name):
    assert row_of(closed(is_closed))[0] == name


@pytest.mark.parametrize(
    "parts",
    [
        {"undecodable": Counter({"/rst_control/state": 3})},
        {"missing_fields": {"/rst_control/state: no field phase"}},
        {"clock_offsets": {"/rst_control/state": 0.8}},
    ],
)
def test_a_session_of_which_something_is_left_out_or_wrong_is_incomplete(row_of, parts):
    assert row_of(replace(closed(), **parts))[0] == "first (incomplete)"


def test_a_session_of_other_times_or_places_is_incomplete(row_of):
    topics = {"/left/rst_control/state": TopicCount("rst_control/ControllerState", 1)}
    assert row_of(closed(topics=topics))[0] == "first (incomplete)"
    assert row_of(closed(clock_steps=[ClockStep(2, 1)]))[0] == "first (incomplete)"


def test_the_begin_of_a_session_has_a_zone(row_of, pool_of, tmp_path):
    data = closed(topics={"/t": TopicCount("std_msgs/String", 1, first=START, last=START)})
    began = datetime.fromtimestamp(START * 1e-9).astimezone()
    assert row_of(data)[1] == f"{began:%Y-%m-%d %H:%M %Z}"
    assert f"{began:%d %B %Y %Z}" in folder_page(pool_of(data), {}, tmp_path)


def test_a_page_below_a_folder_whose_name_is_not_utf_8_has_a_link():
    page = Path(os.fsdecode(b"/sessions/M\xfcller/report.html"))
    assert link(page, Path("/sessions")) == "M%FCller/report.html"

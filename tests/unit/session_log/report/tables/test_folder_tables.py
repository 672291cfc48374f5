# SPDX-License-Identifier: BSD-3-Clause

import pytest

from session_log.mcap_file.reader import FileCondition
from session_log.mcap_file.summary import RecordingSummary
from session_log.report.pool.pool import Pool
from session_log.report.session.session_data import SessionData
from session_log.report.session.shaft import rcm_from_joints
from session_log.report.session.summary import summarise
from session_log.report.tables.folder_tables import sessions_table


@pytest.mark.parametrize(("is_closed", "name"), [(True, "first"), (False, "first (incomplete)")])
def test_an_incomplete_recording_is_named_so(report_config, tmp_path, is_closed, name):
    data = SessionData(RecordingSummary(FileCondition(is_closed=is_closed)))
    summary = summarise("first", data, [], rcm_from_joints(data, report_config), report_config)
    pool = Pool(report_config)
    pool.add(tmp_path / "s.mcap", None, summary)
    assert sessions_table(pool, tmp_path).rows[0][0] == name

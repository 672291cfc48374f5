# SPDX-License-Identifier: BSD-3-Clause
"""The report of a session or of many: one HTML page, its figures, its tables."""

from session_log.report.many_sessions import FolderReport, folder
from session_log.report.one_session import Report, write_report

__all__ = ["FolderReport", "Report", "folder", "write_report"]

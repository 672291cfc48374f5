# SPDX-License-Identifier: BSD-3-Clause
"""The report of a session: one HTML page and its figures."""

from session_log.report.build import Report, write_report

__all__ = ["Report", "write_report"]

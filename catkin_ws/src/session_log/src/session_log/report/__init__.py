# SPDX-License-Identifier: BSD-3-Clause
"""The report of a session or of many: one HTML page, its figures, its tables."""

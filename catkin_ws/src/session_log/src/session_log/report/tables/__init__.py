# SPDX-License-Identifier: BSD-3-Clause
"""Tables of the report, as HTML, CSV and LaTeX."""

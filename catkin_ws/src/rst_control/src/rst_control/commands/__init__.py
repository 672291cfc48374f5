# SPDX-License-Identifier: BSD-3-Clause
"""The commands: one row each in `table.py`, and one file for each kind of motion."""

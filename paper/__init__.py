# SPDX-License-Identifier: BSD-3-Clause
"""The paper's experiment again: every command many times, in several synthetic voices."""

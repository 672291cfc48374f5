# SPDX-License-Identifier: BSD-3-Clause
"""A session as tables and sound."""

# SPDX-License-Identifier: BSD-3-Clause
"""The sessions: what is said next, by whom, in which room, and the running system that hears it."""

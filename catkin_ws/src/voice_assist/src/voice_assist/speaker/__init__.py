# SPDX-License-Identifier: BSD-3-Clause
"""Whose voice it is: motion commands from the enrolled voice only, "stop" from anyone."""

# SPDX-License-Identifier: BSD-3-Clause
"""Stops at random moments of every state."""

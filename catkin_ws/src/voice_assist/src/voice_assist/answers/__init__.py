# SPDX-License-Identifier: BSD-3-Clause
"""Spoken answers: what is said aloud of a command that was taken, or why it was not."""

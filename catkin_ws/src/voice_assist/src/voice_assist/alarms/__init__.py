# SPDX-License-Identifier: BSD-3-Clause
"""Alarms: what happened to the robot as a sound, a line and what to do next."""

# SPDX-License-Identifier: BSD-3-Clause
"""The robot as the voice node knows it: its commands, its state, its own speech."""

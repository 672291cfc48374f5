# SPDX-License-Identifier: BSD-3-Clause
"""One person's voice profile: its files, and how it is activated."""

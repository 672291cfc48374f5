# SPDX-License-Identifier: BSD-3-Clause
"""The command `voice_assist`."""

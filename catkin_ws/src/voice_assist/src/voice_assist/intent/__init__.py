# SPDX-License-Identifier: BSD-3-Clause
"""From a transcript to a command or a refusal."""

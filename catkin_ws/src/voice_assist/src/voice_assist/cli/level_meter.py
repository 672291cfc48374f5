# SPDX-License-Identifier: BSD-3-Clause
"""A bar of the sound's level, for the terminal."""

from __future__ import annotations

QUIETEST_DB = -60.0  # [dB] of full scale; an empty bar
_CLIPPING_DB = -1.0
_WIDTH = 40  # characters


def level_bar(level: float) -> list[tuple[str, str]]:
    """Text and style of the full part, then of the empty part; red where the sound clips.

    Args:
        level: [dB] of full scale.
    """
    share = (max(level, QUIETEST_DB) - QUIETEST_DB) / -QUIETEST_DB
    full = min(round(_WIDTH * share), _WIDTH)
    style = "red" if level > _CLIPPING_DB else "green"
    return [("█" * full, style), ("·" * (_WIDTH - full), "dim")]

# SPDX-License-Identifier: BSD-3-Clause
"""Names of nodes: as they claim them, and as settings allow them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

from typed_config.errors import ConfigError

MAX_NAME: Final = 100  # characters of a name that are read and shown
UNNAMED: Final = "an unnamed node"
PATTERN: Final = (
    "names of nodes that begin with /, where a * may stand at the end, or [] for anybody"
)


def is_allowed(name: str, patterns: Iterable[str]) -> bool:
    """Whether a name is one of the patterns, of which a last `*` stands for any ending.

    No pattern at all allows anybody.
    """
    patterns = tuple(patterns)
    return not patterns or any(
        name.startswith(p[:-1]) if p.endswith("*") else name == p for p in patterns
    )


def caller_name(claimed: object) -> str:
    """Name that a node gives itself, as short and printable as the event log needs it."""
    if not isinstance(claimed, str) or not claimed:
        return UNNAMED
    return "".join(c if c.isprintable() else "?" for c in claimed[:MAX_NAME])


def require_names(key: str, patterns: Iterable[str]) -> None:
    """Refuse patterns that no name of a node fits.

    Raises:
        typed_config.ConfigError: Names the key.
    """
    for pattern in patterns:
        if not pattern.startswith("/") or "*" in pattern[:-1]:
            raise ConfigError(key, pattern, PATTERN)

# SPDX-License-Identifier: BSD-3-Clause
"""The part of controller.yaml that says who may give commands, and how often."""

from __future__ import annotations

from dataclasses import dataclass

from typed_config import ConfigError, integer, number, text

PATTERN = "names of nodes that begin with /, where a * may stand at the end, or [] for anybody"


@dataclass(frozen=True, kw_only=True)
class CallersConfig:
    """Who may call the services and send goals; "stop" is taken from anybody, however often."""

    allowed: tuple[str, ...] = text()
    rate: float = number(1.0, 1000.0, "1/s")
    burst: int = integer(1, 1000)

    def __post_init__(self) -> None:
        require_names("allowed", self.allowed)


def require_names(key: str, patterns: tuple[str, ...]) -> None:
    """Refuse patterns that no name of a node fits.

    Raises:
        typed_config.ConfigError: Names the key.
    """
    for pattern in patterns:
        if not pattern.startswith("/") or "*" in pattern[:-1]:
            raise ConfigError(key, pattern, PATTERN)

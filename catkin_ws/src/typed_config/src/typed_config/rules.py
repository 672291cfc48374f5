# SPDX-License-Identifier: BSD-3-Clause
"""Rules between keys, for the `__post_init__` of a settings dataclass; its keys are relative."""

from __future__ import annotations

from collections.abc import Sequence

from typed_config.errors import ConfigError


def require(is_allowed: bool, key: str, value: object, allowed: str) -> None:
    """Refuse a value that does not fit the others.

    Raises:
        ConfigError: It does not.
    """
    if not is_allowed:
        raise ConfigError(key, value, allowed)


def require_rising(key: str, pair: tuple[float, float]) -> None:
    """Refuse a range whose ends are swapped or equal.

    Raises:
        ConfigError: They are.
    """
    require(pair[0] < pair[1], key, list(pair), "the smaller number first")


def require_way(key: str, way: Sequence[float]) -> None:
    """Refuse three numbers that point nowhere.

    Raises:
        ConfigError: They do not.
    """
    require(len(way) == 3 and any(way), key, list(way), "three numbers, not all 0")

# SPDX-License-Identifier: BSD-3-Clause
"""The error of settings: names key, value and what was allowed."""

from __future__ import annotations

import reprlib

_LONGEST = 80  # characters of a value in an error
_short = reprlib.Repr()
_short.maxlist = _short.maxtuple = _short.maxdict = 12
_short.maxstring = _short.maxlong = _short.maxother = _LONGEST
_short.maxlevel = 3


class ConfigError(ValueError):
    """A settings key is unknown, missing or holds what it may not."""

    def __init__(self, key: str, value: object, allowed: str) -> None:
        super().__init__(f"{key} is {_shown(value)}, allowed: {allowed}")
        self.key, self.value, self.allowed = key, value, allowed

    def under(self, where: str) -> ConfigError:
        """The same error, its key seen from further outside."""
        return type(self)(join(where, self.key), self.value, self.allowed)


class Missing:
    """Stands in an error for a value that was not given."""

    def __repr__(self) -> str:
        return "missing"


def join(where: str, key: str) -> str:
    """Path of a key below `where`, which is a file's name, the path of a mapping, or empty."""
    return f"{where}: {key}" if where.endswith((".yaml", ".yml")) else f"{where}.{key}".lstrip(".")


def _shown(value: object) -> str:
    words = _short.repr(value)  # bounded: repr() of hostile YAML may never end
    return words if len(words) <= _LONGEST else words[: _LONGEST - 3] + "..."

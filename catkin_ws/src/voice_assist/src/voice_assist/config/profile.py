# SPDX-License-Identifier: BSD-3-Clause
"""Whose profile is used; config/profile.yaml explains each key."""

from __future__ import annotations

import re
from dataclasses import dataclass

from typed_config import require, text

NOBODY = "none"  # the name that means: the base alone, for everybody
NAME = re.compile(r"[a-z0-9][a-z0-9_-]{0,39}")


@dataclass(frozen=True, kw_only=True)
class ProfileConfig:
    """The profile that the voice part uses."""

    name: str = text()
    folder: str = text(may_be_empty=True)
    sha256: str = text(may_be_empty=True)

    def __post_init__(self) -> None:
        """Check what no key shows alone."""
        if self.is_used:
            require_name(self.name, "name")

    @property
    def is_used(self) -> bool:
        """Somebody's profile is used, not the base alone."""
        return self.name != NOBODY


def require_name(name: str, key: str = "profile name") -> None:
    """Refuse what cannot be the name of a profile.

    Raises:
        ConfigError: It names nobody, or would not do as a folder's name everywhere.
    """
    allowed = "up to 40 of a to z, 0 to 9, - and _, the first no sign, and not none"
    require(bool(NAME.fullmatch(name)) and name != NOBODY, key, name, allowed)

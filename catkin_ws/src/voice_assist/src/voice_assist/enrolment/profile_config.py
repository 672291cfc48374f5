# SPDX-License-Identifier: BSD-3-Clause
"""Whose profile is in force; config/profile.yaml explains each key."""

from __future__ import annotations

from dataclasses import dataclass

from typed_config import text
from voice_assist.enrolment.manifest import NOBODY, require_name


@dataclass(frozen=True, kw_only=True)
class ProfileConfig:
    """The profile that the voice part uses."""

    name: str = text()
    folder: str = text(may_be_empty=True)
    sha256: str = text(may_be_empty=True)

    def __post_init__(self) -> None:
        """Check what no key shows alone."""
        if self.is_used:
            require_name(self.name)

    @property
    def is_used(self) -> bool:
        """Somebody's profile is in force, not the base alone."""
        return self.name != NOBODY

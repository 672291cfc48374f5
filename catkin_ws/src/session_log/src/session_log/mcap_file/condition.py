# SPDX-License-Identifier: BSD-3-Clause
"""What a pass through a file finds out about it."""

from __future__ import annotations

from dataclasses import dataclass, field

from session_log.mcap_file.writer import LIBRARY
from session_log.types import Damage


@dataclass
class FileCondition:
    """What one pass through a file found out about it; complete when the pass is."""

    size: int = 0  # [B]
    is_closed: bool = False  # has its ending: the recorder was not killed
    checksum: str = "none"  # good, wrong or none
    library: str = ""  # what wrote the file; empty: its header is lost
    damage: list[Damage] = field(default_factory=list)
    metadata: list[tuple[str, dict[str, str]]] = field(default_factory=list)

    @property
    def is_ours(self) -> bool:
        """Whether our recorder wrote the file, or copied it; not known without a header."""
        return self.library.startswith(LIBRARY)

    @property
    def is_foreign(self) -> bool:
        """Whether another program wrote the file; not known without a header."""
        return bool(self.library) and not self.is_ours

    @property
    def is_numbered(self) -> bool:
        """Whether our recorder wrote it: numbered, in order of time. Taken so without a header."""
        return self.library in (LIBRARY, "")

    @property
    def troubles(self) -> list[str]:
        """What is wrong with the file, in words; empty: it is sound."""
        words = []
        if not self.is_closed:
            words.append("not closed: the recorder was killed, or is still running")
        if self.checksum == "wrong":
            words.append("checksum wrong: the file was changed after it was written")
        return words + [f"lost {damage}" for damage in self.damage]

    def latest(self, name: str) -> dict[str, str]:
        """Return the last metadata record of a name; empty if there is none."""
        return next((values for n, values in reversed(self.metadata) if n == name), {})

# SPDX-License-Identifier: BSD-3-Clause
"""Losses that were measured, kept beside the results: a thousand take longer than one sitting.

A row is a loss and the digest of the code that decided on it; rows of other code are left alone and
not counted. Of 695 losses only the figures are left (`earlier.json`): they are told as they were,
and counted.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

from bench.common.kept_rows import rows_of
from bench.safety.losses.judge import Loss
from support.figures import RESULTS, Figure

FOLDER = RESULTS / "safety" / "losses_rows"
_MOVING = ": in motion when lost"  # a figure of each victim and way, out of how many


@dataclass(frozen=True)
class Earlier:
    """Figures of losses whose rows are gone, with the day and the code that they are of."""

    figures: tuple[Figure, ...] = ()
    when: str = ""

    def count(self, group: str) -> int:
        """Losses of a victim by a way, such as "roscore, SIGKILL"."""
        return sum(int(f.target or 0) for f in self.figures if f.name == group + _MOVING)

    def joined(self, figures: Sequence[Figure]) -> list[Figure]:
        """New figures with these: sums where a figure counts over all, else one after the other."""
        if not self.figures:
            return list(figures)
        new = {f.name for f in figures}
        found = []
        for one in figures:
            old = next((f for f in self.figures if f.name == one.name), None)
            found.append(one if old is None or not _is_total(one) else _sum(old, one))
        total = next(f.value for f in self.figures if f.name == "losses")
        found.append(Figure("of these earlier", total, "", note=f"({self.when})"))
        for old in self.figures:
            if not _is_total(old) and not old.name.startswith("load average"):
                again = ", earlier" if old.name in new else ""
                found.append(replace(old, name=old.name + again))
        return found


def earlier(folder: Path = FOLDER) -> Earlier:
    """What earlier.json holds; nothing where there is none."""
    path = folder / "earlier.json"
    if not path.is_file():
        return Earlier()
    data = json.loads(path.read_text(encoding="utf-8"))
    when = f"{data['machine']['date']}, {data['machine']['commit']}"
    return Earlier(tuple(Figure(**fields) for fields in data["figures"]), when)


def read(kept: Path, code: str) -> list[Loss]:
    """Losses in a file that are of a code.

    Args:
        kept: May be missing.
        code: Digest of what decides on a loss.
    """
    found = rows_of(kept, "code", code)
    return [Loss(**{**row, "objections": tuple(row["objections"])}) for row in found]


def append(kept: Path, loss: Loss, code: str) -> None:
    """Keep one more."""
    with kept.open("a", encoding="utf-8") as lines:
        lines.write(json.dumps({**asdict(loss), "code": code}) + "\n")


def _is_total(figure: Figure) -> bool:
    return figure.name == "losses" or figure.name.startswith(("arm ", "set aside"))


def _sum(old: Figure, new: Figure) -> Figure:
    """Of counts over all; what was planned holds for both together."""
    target = new.target
    if target is not None and new.name != "losses":
        target += old.target or 0.0
    return replace(new, value=old.value + new.value, target=target)

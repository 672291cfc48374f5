# SPDX-License-Identifier: BSD-3-Clause
"""Near misses, denied commands and commands inside sentences, in held-out voices."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from bench import voice_sets
from bench.figures import Figure
from bench.voice_bounds import at_most
from bench.voice_phrases import ALL, TRAINED
from bench.voice_run import THIN, Evaluated, Row, evaluated
from voice_assist.config import load_voice_config

FULL = 12  # voices per phrase at THIN=1


def near() -> Evaluated:
    """The phrases through the pipeline, armed."""
    return evaluated("near_misses", voice_sets.near_misses(max(1, FULL // (2 * THIN))))


def measure() -> list[Figure]:
    """Share of them taken as a motion; stops apart, since they are safe."""
    rows = near().rows
    return figures(rows)


def figures(rows: Sequence[Row]) -> list[Figure]:
    """What was taken of phrases that are no command."""
    motions = {c.phrase for c in load_voice_config().commands.commands if c.is_motion}
    found = [_share("near misses: taken as motion", rows, motions, 0.005)]
    new = [row for row in rows if row.transcript not in TRAINED]
    found.append(_share("near misses, words never trained on: taken as motion", new, motions))
    for name, phrases in ALL.items():
        some = [row for row in rows if row.transcript in phrases]
        target = 0.0 if name == "denied" else None
        found.append(_share(f"{name}: taken as motion", some, motions, target))
        found.append(_share(f"{name}: taken as stop", some, {"stop"}))
    found.append(_share("near misses: taken as hey robot", rows, {"hey robot"}))
    found.append(_share("near misses: taken as terminate", rows, {"terminate"}))
    return found


def _share(
    name: str, rows: Sequence[Row], commands: Iterable[str], target: float | None = None
) -> Figure:
    wrong = [row for row in rows if not set(commands).isdisjoint(row.taken)]
    said = ", ".join(sorted({f"{row.transcript!r}" for row in wrong}))
    bound = at_most(len(wrong), len(rows))
    note = f"({len(wrong)} of {len(rows)}, at most {bound:.4f} with 95 %{said and ': ' + said})"
    return Figure(name, len(wrong) / len(rows), "of all", target, note=note)

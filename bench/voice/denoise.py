# SPDX-License-Identifier: BSD-3-Clause
"""Accuracy with noise reduction on, off and for endpointing only, in theatre noise."""

from __future__ import annotations

import json

from bench.voice import clips as voice_sets
from bench.voice.evaluate_once import FOLDER, THIN, evaluated
from support.exact_bounds import at_least
from support.figures import Figure

MODES = ("off", "endpointing_only", "on")
SNRS = (20, 10, 6, 0)  # [dB]


def measure() -> list[Figure]:
    """A row per mode and level; the same clips and the same noise in all."""
    clips = voice_sets.synthetic_commands(1 if THIN == 1 else 2 * THIN)
    figures, table = [], {}
    for snr in SNRS:
        for mode in MODES:
            found = evaluated(
                f"denoise_{mode}_{snr}dB",
                clips,
                voice_sets.theatre(),
                snr,
                (("audio.denoise.mode", mode),),
            )
            said = [row for row in found.rows if row.command]
            right = sum(set(row.taken) == {row.command} for row in said)
            false = sum(bool(row.taken) for row in found.rows if not row.command)
            n, negatives = len(said), len(found.rows) - len(said)
            bound = at_least(right, n)
            note = f"({right} of {n}, at least {bound:.3f}; near misses taken {false}/{negatives})"
            figures.append(
                Figure(f"noise reduction {mode}, {snr} dB", right / n, "right", note=note)
            )
            table[f"{mode} {snr} dB"] = {"right": right, "n": n, "false": false, "of": negatives}
    text = json.dumps(table, indent=1) + "\n"
    (FOLDER / "denoise_table.json").write_text(text, encoding="utf-8")
    return figures

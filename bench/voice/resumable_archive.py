# SPDX-License-Identifier: BSD-3-Clause
"""Pieces of the longest measurements, kept beside the results.

Tens of hours take longer than one sitting, or one machine. A row is a piece with the key of what
heard it (`voice_chunks.identity`); of what was said in it, only what was taken is left, for no
more is counted. Rows of another key are left alone.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from bench.common.kept_rows import rows_of
from bench.voice import resumable
from bench.voice.resumable import MODEL, Chunk
from support.figures import RESULTS

FOLDER = RESULTS / "voice" / "pieces"


def restore(part: str, folder: Path = FOLDER, model: str = MODEL) -> int:
    """Put the pieces that were kept where `voice_chunks.measured` finds them; says how many."""
    there = resumable.folder_of(part, model)
    new = [
        row for row in _rows(part, folder, model) if not (there / f"{row['piece']}.json").is_file()
    ]
    for row in new:
        text = json.dumps(row["records"])
        (there / f"{row['piece']}.json").write_text(text, encoding="utf-8")
    return len(new)


def keep(part: str, plan: Sequence[Chunk], folder: Path = FOLDER, model: str = MODEL) -> int:
    """Keep all pieces of a plan that are done and not kept yet; says how many."""
    kept = {row["piece"] for row in _rows(part, folder, model)}
    there = resumable.folder_of(part, model)
    names = [chunk.name() for chunk in plan]
    new = [n for n in names if n not in kept and (there / f"{n}.json").is_file()]
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / f"{part}.jsonl").open("a", encoding="utf-8") as lines:
        for name in new:
            records = json.loads((there / f"{name}.json").read_text(encoding="utf-8"))
            row = {"key": resumable.identity(model), "piece": name}
            lines.write(json.dumps({**row, "records": [_short(r) for r in records]}) + "\n")
    return len(new)


def begun_last(spans: Sequence[Sequence[Any]], at: float) -> Sequence[Any] | None:
    """The utterance that was last begun; None before the first.

    Args:
        spans: Utterances in their order, each with its beginning [s] first.
        at: In the same sound [s].
    """
    return next((span for span in reversed(spans) if span[0] <= at), None)


def _rows(part: str, folder: Path, model: str) -> list[dict[str, Any]]:
    return rows_of(folder / f"{part}.jsonl", "key", resumable.identity(model))


def _short(record: dict[str, Any]) -> dict[str, Any]:
    """Without what was not taken; of the utterances, those begun last before something was."""
    heard, label = dict(record["heard"]), dict(record["label"])
    heard["said"] = [one for one in heard["said"] if one["is_taken"]]
    if "spans" in label:
        told = [begun_last(label["spans"], one["at"]) for one in heard["said"]]
        label["spans"] = [span for span in label["spans"] if span in told]
    return {"label": label, "heard": heard}

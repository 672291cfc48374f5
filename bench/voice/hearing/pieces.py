# SPDX-License-Identifier: BSD-3-Clause
"""Scenes through the pipeline, in pieces that are kept.

Pieces lie under .cache/bench/chunks/<key>/, where the key is made of the networks, the settings and
what the pipeline decides on a fixed set of clips: whatever changes one of them begins anew, and a
move of code does not. Pieces of the longest measurements lie beside the results, too: a row is a
piece with its key. Of what was said in it, only what was taken is left, for no more is counted.
What the environment decides, such as another MODEL: see bench/common/resumable.py.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import astuple, dataclass
from pathlib import Path
from random import Random
from typing import Any, Protocol

from bench.common import resumable
from bench.voice.hearing.fingerprint import identity, identity_in_motion, outline
from bench.voice.hearing.replay_stream import SceneListener, SceneResult, SoundScene
from support import product_code
from support.figures import RESULTS, Figure
from support.product_code import HEARING
from voice_assist.assembly import limit_torch
from voice_assist.config import load_voice_config

MODEL = resumable.MODEL
FOLDER = RESULTS / "voice" / "pieces"
CODES, RESTORED = "codes.txt", "kept beside the results"  # by which code the pieces were heard

Label = dict[str, Any]  # what is known of a scene; JSON
_HEARD_BY = set[str]()  # codes of the pieces that this process counted


class Chunk(Protocol):
    """A piece of work: small enough to be lost, large enough to be worth a file."""

    def name(self) -> str:
        """Identifies the piece within its part; changes when its content does."""
        ...

    def scenes(self) -> Iterator[tuple[Label, SoundScene]]:
        """What to stream."""
        ...


class Trial(Protocol):
    """One scene of many alike; a dataclass whose fields identify it."""

    def scene(self) -> tuple[Label, SoundScene]:
        """What to stream."""
        ...


@dataclass(frozen=True)
class TrialChunk:
    """Some trials in one piece."""

    trials: tuple[Trial, ...]
    is_moving: bool = False  # how a robot that moves is listened for counts, too

    def name(self) -> str:
        """Digest of all that is streamed, and of how."""
        plan = [astuple(trial) for trial in self.trials]  # type: ignore[call-overload]
        _, first = self.trials[0].scene()
        more = (identity_in_motion(MODEL),) if self.is_moving else ()
        return resumable.digest(plan, outline(first.sound), *more)

    def scenes(self) -> Iterator[tuple[Label, SoundScene]]:
        """One for each trial."""
        return (trial.scene() for trial in self.trials)


def in_chunks(
    trials: Sequence[Trial], size: int, is_moving: bool = False, is_whole: bool = False
) -> list[TrialChunk]:
    """Trials in pieces, SHARE of them; in an order by chance, so that a part is like the whole.

    Args:
        trials: Of one set.
        size: Of a piece.
        is_moving: How a robot that moves is listened for makes other pieces.
        is_whole: All of them, whatever SHARE says.
    """
    mixed = list(trials)
    Random(0).shuffle(mixed)
    some = mixed if is_whole else resumable.share_of(mixed)
    return [TrialChunk(tuple(some[i : i + size]), is_moving) for i in range(0, len(some), size)]


@dataclass(frozen=True)
class SceneRecord:
    """A scene and what it came to."""

    label: Label
    heard: SceneResult


def measured(
    part: str, plans: Mapping[str, Sequence[Chunk]], model: str = MODEL
) -> dict[str, list[SceneRecord]]:
    """Stream the pieces that are not there yet; gives all that are, in the order of the plans.

    Args:
        part: Names the measurement.
        plans: Pieces by the set that they belong to.
        model: That listens.
    """
    folder = folder_of(part, model)
    jobs = {
        name: [(chunk, folder / f"{chunk.name()}.json") for chunk in plan]
        for name, plan in plans.items()
    }
    missing = [job for some in jobs.values() for job in some if not job[1].is_file()]
    _note_code(folder, product_code.identity(HEARING) if missing else "")
    if missing:
        print(f"{part}: {len(missing)} of {sum(map(len, jobs.values()))} pieces to do", flush=True)
        with _pool(model, min(resumable.JOBS, len(missing))) as pool:
            list(resumable.carried_out(part, missing, _stream, pool))
    return {
        name: [record for _, path in some if path.is_file() for record in read(path)]
        for name, some in jobs.items()
    }


def found(
    part: str, plans: Mapping[str, Sequence[Trial]], size: int, is_moving: bool = False
) -> tuple[dict[str, list[SceneRecord]], Figure]:
    """Records of the sets of trials that have any, and the figure of how many scenes there are.

    Args:
        part: Names the measurement.
        plans: Trials by the set that they belong to.
        size: Of a piece.
        is_moving: As `in_chunks` takes it.
    """
    every = measured(part, {name: in_chunks(t, size, is_moving) for name, t in plans.items()})
    some = {name: records for name, records in every.items() if records}
    counts = [sum(map(len, sets.values())) for sets in (some, plans)]
    return some, resumable.measured(counts[0], "scenes", counts[1])


def folder_of(part: str, model: str = MODEL) -> Path:
    """Where the pieces of a measurement lie; made where it is missing."""
    folder = resumable.CACHE / "chunks" / identity(model) / part
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def is_of_other_code() -> bool:
    """Whether a piece that this process counted was heard by other code than the present one."""
    return bool(_HEARD_BY - {product_code.identity(HEARING)})


def _note_code(folder: Path, code: str) -> None:
    """Note by which code pieces of a folder are heard; empty: none is added."""
    file = folder / CODES
    known = set(file.read_text(encoding="utf-8").splitlines()) if file.is_file() else set[str]()
    known |= {code} if code else set()
    file.write_text("".join(f"{one}\n" for one in sorted(known)), encoding="utf-8")
    _HEARD_BY.update(known)


def up_to(part: str, plan: Sequence[Chunk], count: int, model: str = MODEL) -> list[Chunk]:
    """The first pieces of a plan, and of the others those that earlier goes have done."""
    folder = folder_of(part, model)
    done = [chunk for chunk in plan[count:] if (folder / f"{chunk.name()}.json").is_file()]
    return [*plan[:count], *done]


def read(path: Path) -> list[SceneRecord]:
    """Records of a piece."""
    data = json.loads(path.read_text(encoding="utf-8"))
    return [SceneRecord(one["label"], SceneResult.from_json(one["heard"])) for one in data]


def restore(part: str, folder: Path = FOLDER, model: str = MODEL) -> int:
    """Put the pieces that lie beside the results where `measured` finds them; gives their number.

    Args:
        part: Names the measurement.
        folder: With one file for each part.
        model: That listened.
    """
    there = folder_of(part, model)
    rows = resumable.rows_of(folder / f"{part}.jsonl", identity(model))
    new = [row for row in rows if not (there / f"{row['piece']}.json").is_file()]
    for row in new:
        resumable.write(there / f"{row['piece']}.json", row["records"])
    _note_code(there, RESTORED if new else "")
    return len(new)


def keep(part: str, plan: Sequence[Chunk], folder: Path = FOLDER, model: str = MODEL) -> int:
    """Keep beside the results the pieces of a plan that are done and not kept yet; their number.

    Args:
        part: Names the measurement.
        plan: Its pieces.
        folder: With one file for each part.
        model: That listened.
    """
    path, key, there = folder / f"{part}.jsonl", identity(model), folder_of(part, model)
    kept = {row["piece"] for row in resumable.rows_of(path, key)}
    names = [chunk.name() for chunk in plan]
    new = [n for n in names if n not in kept and (there / f"{n}.json").is_file()]
    for name in new:
        records = json.loads((there / f"{name}.json").read_text(encoding="utf-8"))
        resumable.append(path, key, {"piece": name, "records": [_short(r) for r in records]})
    return len(new)


def begun_last(spans: Sequence[Sequence[Any]], at: float) -> Sequence[Any] | None:
    """The utterance that was last begun; None before the first.

    Args:
        spans: Utterances in their order, each with its beginning [s] first.
        at: In the same sound [s].
    """
    return next((span for span in reversed(spans) if span[0] <= at), None)


def _short(record: dict[str, Any]) -> dict[str, Any]:
    """Without what was not taken; of the utterances, those begun last before something was."""
    heard, label = dict(record["heard"]), dict(record["label"])
    heard["said"] = [one for one in heard["said"] if one["is_taken"]]
    if "spans" in label:
        begun = [begun_last(label["spans"], one["at"]) for one in heard["said"]]
        label["spans"] = [span for span in label["spans"] if span in begun]
    return {"label": label, "heard": heard}


def _pool(model: str, jobs: int) -> Executor:
    """Processes of their own, which load their networks once."""
    return resumable.pool(jobs, _prepare, model)


_LISTENERS: list[SceneListener] = []  # one per process, built by its start


def _prepare(model: str) -> None:
    limit_torch(load_voice_config())
    _LISTENERS[:] = [SceneListener(model)]


def _stream(chunk: Chunk) -> list[dict[str, Any]]:
    listen = _LISTENERS[0]
    return [{"label": label, "heard": listen(scene).to_json()} for label, scene in chunk.scenes()]

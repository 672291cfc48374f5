# SPDX-License-Identifier: BSD-3-Clause
"""Long measurements in pieces that are kept, so that they can be made in several goes.

What a piece came to lies under .cache/bench/chunks/<key>/, where the key is made of the networks,
the settings and what the pipeline decides on a fixed set of clips: whatever changes one of them
begins anew, and a move of code does not. In the environment:
MODEL another model than the shipped one, JOBS the processes, MINUTES after which no more pieces are
begun, SHARE the part of a plan to take (0.02: one in fifty, to try).
"""

from __future__ import annotations

import ast
import hashlib
import json
import multiprocessing
import os
import signal
import threading
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Executor, ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any, Protocol, TypeVar

from bench.common.pieces import do_pieces
from bench.voice import clips, fingerprint
from bench.voice.replay_stream import Heard, Listener, Scene
from voice_assist.assembly import limit_torch, make_recognizer, make_spotter
from voice_assist.config import CONFIG_DIR, load_voice_config
from voice_assist.pipeline import pipeline

MODEL = os.environ.get("MODEL", "embedded")
JOBS = int(os.environ.get("JOBS") or os.cpu_count() or 1)
MINUTES = float(os.environ.get("MINUTES", "inf"))
SHARE = float(os.environ.get("SHARE", "1"))
UNHEARD = {"recognizer__hung_after": 0.35}  # of the node alone; as when rows were first kept

_T = TypeVar("_T")
Label = dict[str, Any]  # what is known of a scene; JSON


class Chunk(Protocol):
    """A piece of work: small enough to be lost, large enough to be worth a file."""

    def name(self) -> str:
        """Tells the piece from all others of its part, and changes when its content does."""
        ...

    def scenes(self) -> Iterator[tuple[Label, Scene]]:
        """What to stream."""
        ...


@dataclass(frozen=True)
class Record:
    """A scene and what it came to."""

    label: Label
    heard: Heard


def measured(
    part: str, plans: Mapping[str, Sequence[Chunk]], model: str = MODEL
) -> dict[str, list[Record]]:
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
    if missing:
        print(f"{part}: {len(missing)} of {sum(map(len, jobs.values()))} pieces to do", flush=True)
        _do(part, missing, model)
    return {
        name: [record for _, path in some if path.is_file() for record in read(path)]
        for name, some in jobs.items()
    }


def folder_of(part: str, model: str = MODEL) -> Path:
    """Where the pieces of a measurement lie; made where it is missing."""
    folder = clips.CACHE / "chunks" / identity(model) / part
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def up_to(part: str, plan: Sequence[Chunk], count: int, model: str = MODEL) -> list[Chunk]:
    """The first pieces of a plan, and of the others those that earlier goes have done."""
    folder = folder_of(part, model)
    done = [chunk for chunk in plan[count:] if (folder / f"{chunk.name()}.json").is_file()]
    return [*plan[:count], *done]


def read(path: Path) -> list[Record]:
    """Records of a piece."""
    data = json.loads(path.read_text(encoding="utf-8"))
    return [Record(one["label"], Heard.from_json(one["heard"])) for one in data]


def share_of(plan: Sequence[_T]) -> list[_T]:
    """The part of a plan that SHARE asks for, at least one."""
    return list(plan[: max(1, round(SHARE * len(plan)))])


def digest(*values: object) -> str:
    """Short name of values, by their `repr`."""
    return hashlib.sha256(repr(values).encode()).hexdigest()[:16]


@cache
def source(*modules: ModuleType) -> str:
    """Digest of modules that make sound, so that pieces of an earlier way are made anew."""
    return digest([_code_of(Path(str(module.__file__))) for module in modules])


@cache
def identity(model: str = MODEL) -> str:
    """Key of all that decides what is heard: networks, settings, and decisions on fixed clips."""
    config = load_voice_config(CONFIG_DIR, recognizer__model=model)
    network = make_recognizer(config).model_hash
    _, spotter = make_spotter(config.spotter)
    named = load_voice_config(CONFIG_DIR, **UNHEARD)  # by what is in the file, not by its name
    settings = fingerprint.values(named)
    now = digest(network, spotter, settings, code(Path(pipeline.__file__).parent.parent))
    folder = clips.CACHE / "fingerprints"
    decided = fingerprint.fingerprint(model, now, folder)
    return digest(network, spotter, settings, decided)


def code(folder: Path) -> str:
    """Digest of the modules in a folder, whatever their comments and layout."""
    parts = []
    for path in sorted(folder.rglob("*.py")):
        parts.append((str(path.relative_to(folder)), _code_of(path)))
    return digest(parts)


def _code_of(path: Path) -> str:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        if isinstance(body, list):  # docstrings change nothing
            body[:] = [s for s in body if not (isinstance(s, ast.Expr) and _is_text(s.value))]
    return ast.dump(tree)


def _is_text(value: ast.expr) -> bool:
    return isinstance(value, ast.Constant) and isinstance(value.value, str)


def _do(part: str, missing: Sequence[tuple[Chunk, Path]], model: str) -> None:
    """In processes of their own, which load their networks once; each writes what it finishes."""
    with _pool(model, min(JOBS, len(missing))) as pool:
        do_pieces(part, missing, _one, pool, JOBS, MINUTES)


def _pool(model: str, jobs: int) -> Executor:
    context = multiprocessing.get_context("spawn")
    return ProcessPoolExecutor(jobs, context, _prepare, (model,))


_LISTENERS: list[Listener] = []  # one per process, built by its start


def _prepare(model: str) -> None:
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # Ctrl-C ends it; an unfinished piece is lost
    threading.Thread(target=_end_with_parent, name="end with parent", daemon=True).start()
    limit_torch(load_voice_config())
    _LISTENERS[:] = [Listener(model)]


def _end_with_parent() -> None:
    """Nobody waits for what this process finds once the one that started it is gone."""
    if (parent := multiprocessing.parent_process()) is not None:
        parent.join()
        os._exit(1)


def _one(chunk: Chunk, path: Path) -> None:
    records = [
        {"label": label, "heard": _LISTENERS[0](scene).to_json()} for label, scene in chunk.scenes()
    ]
    unfinished = path.with_suffix(f".{os.getpid()}.tmp")
    unfinished.write_text(json.dumps(records), encoding="utf-8")
    unfinished.rename(path)

# SPDX-License-Identifier: BSD-3-Clause
"""Long measurements in pieces that are kept, so that they can be made in several goes.

A piece is a file of JSON in a folder that is named by a key. The key is made of all that decides
what a piece comes to, so that whatever changes it begins anew. A result that rests on less never
takes the place of one that rests on more.

In the environment: JOBS the processes, MINUTES after which no piece is begun, SHARE the part of a
plan to take (0.02: one in fifty, to try), RESULTS a folder of the repository to write to instead of
bench/results, MODEL another recogniser than the shipped one, whose results are written aside,
FORCE=1 to write whatever is on file.
"""

from __future__ import annotations

import ast
import hashlib
import json
import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ProcessPoolExecutor, wait
from functools import cache, partial
from pathlib import Path
from types import ModuleType
from typing import Any, TypeVar

from bench.common.part import MEASURED
from support import figures
from support.figures import ROOT, Figure

JOBS = int(os.environ.get("JOBS") or os.cpu_count() or 1)
MINUTES = float(os.environ.get("MINUTES", "inf"))
SHARE = float(os.environ.get("SHARE", "1"))
CACHE = ROOT / ".cache" / "bench"
MODEL = os.environ.get("MODEL", "embedded")
ASIDE = CACHE / "partial"  # for results that rest on less than those on file, or on another model
PLACE = ROOT / os.environ.get("RESULTS", "bench/results" if MODEL == "embedded" else ASIDE)

_T = TypeVar("_T")


# Keys.


def digest(*values: object) -> str:
    """Short name of values, by their `repr`."""
    return hashlib.sha256(repr(values).encode()).hexdigest()[:16]


@cache
def source(*modules: ModuleType) -> str:
    """Digest of modules, whatever their comments and layout."""
    return digest([_code_of(Path(str(module.__file__))) for module in modules])


def code(folder: Path) -> str:
    """Digest of the modules in a folder, whatever their comments and layout.

    Raises:
        ValueError: It holds none.
    """
    paths = sorted(folder.rglob("*.py"))
    if not paths:
        raise ValueError(f"{folder}: no modules")
    return digest([(str(path.relative_to(folder)), _code_of(path)) for path in paths])


def _code_of(path: Path) -> str:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        if isinstance(body, list):  # docstrings change nothing
            body[:] = [s for s in body if not (isinstance(s, ast.Expr) and _is_text(s.value))]
    return ast.dump(tree)


def _is_text(value: ast.expr) -> bool:
    return isinstance(value, ast.Constant) and isinstance(value.value, str)


# Pieces.


def share_of(plan: Sequence[_T]) -> list[_T]:
    """The part of a plan that SHARE asks for, at least one."""
    return list(plan[: max(1, round(SHARE * len(plan)))])


def pool(jobs: int, prepare: Callable[..., None], *arguments: object) -> Executor:
    """Processes that end with this one.

    Args:
        jobs: How many.
        prepare: Is called in each of them at its start.
        arguments: Of that.
    """
    context = multiprocessing.get_context("spawn")
    return ProcessPoolExecutor(jobs, context, partial(_begin, prepare, *arguments))


def carried_out(
    part: str,
    jobs: Iterable[tuple[_T, Path]],
    one: Callable[[_T], Any],
    processes: Executor,
) -> Iterator[Path]:
    """Carry out the pieces that are not there; yields the files of all that are, as they come.

    Args:
        part: Names the measurement.
        jobs: Pieces and the file of each. They are taken one by one, so that a caller who has
            enough may end the iteration.
        one: Carries out a piece in another process; gives what is kept of it, for JSON.
        processes: To do it in.
    """
    began, done = time.monotonic(), 0
    under_way: dict[Future[None], Path] = {}

    def finished() -> Iterator[Path]:
        nonlocal done
        for future in wait(under_way, return_when=FIRST_COMPLETED).done:
            future.result()
            done += 1
            print(f"{part}: {done} done after {time.monotonic() - began:.0f} s", flush=True)
            yield under_way.pop(future)

    for piece, path in jobs:
        if path.is_file():
            yield path
            continue
        while len(under_way) >= JOBS:
            yield from finished()
        if time.monotonic() - began < 60.0 * MINUTES:
            under_way[processes.submit(_keep, one, piece, path)] = path
    while under_way:
        yield from finished()


def remembered(path: Path, make: Callable[[], Any]) -> Any:
    """What a file holds; where it is missing, it is made and kept."""
    if not path.is_file():
        write(path, make())
    return json.loads(path.read_text(encoding="utf-8"))


def write(path: Path, data: object) -> None:
    """Write a file of JSON, whole or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    unfinished = path.with_suffix(f".{os.getpid()}.tmp")
    unfinished.write_text(json.dumps(data), encoding="utf-8")
    unfinished.rename(path)


def _keep(one: Callable[[_T], Any], piece: _T, path: Path) -> None:
    write(path, one(piece))


def _begin(prepare: Callable[..., None], *arguments: object) -> None:
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # Ctrl-C ends it; an unfinished piece is lost
    threading.Thread(target=_end_with_parent, name="end with parent", daemon=True).start()
    prepare(*arguments)


def _end_with_parent() -> None:
    """Nobody waits for what this process finds once the one that started it is gone."""
    if (parent := multiprocessing.parent_process()) is not None:
        parent.join()
        os._exit(1)


# Rows that are kept beside the results: tens of hours take more than one machine.


def rows_of(path: Path, key: str) -> list[dict[str, Any]]:
    """Rows of a key, oldest first, without it; rows of other keys are left alone.

    Args:
        path: A JSON object per line; may be missing.
        key: Of what the rows depend on.
    """
    if not path.is_file():
        return []
    rows = [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]
    return [row for row in rows if row.pop("key", None) == key]


def append(path: Path, key: str, row: Mapping[str, Any]) -> None:
    """Keep one more row of a key."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("a", encoding="utf-8") as lines:
        lines.write(json.dumps({"key": key, **row}) + "\n")


# Results on file.


def measured(amount: float, unit: str, full: float) -> Figure:
    """On how much a result rests; the first figure of a part that can be done in part."""
    return Figure(MEASURED, amount, unit, full, at_most=False)


def kept(name: str, measure: Callable[[], list[Figure]]) -> Callable[[], list[Figure]]:
    """Measure, and choose the place where `support.figures.run` shall write.

    Args:
        name: Of the result, such as "voice/near".
        measure: Gives its figures.
    """

    def measure_and_choose() -> list[Figure]:
        found = measure()
        figures.RESULTS = PLACE if found else ASIDE  # nothing takes no result's place
        rests = next((f for f in found if f.name == MEASURED), None)
        if rests is not None:
            figures.RESULTS = place(f"{name}.json", rests.value, rests.target)
        return found

    return measure_and_choose


def place(name: str, amount: float, full: float | None = None) -> Path:
    """Folder for a result: aside, if what is on file rests on more, and this is not whole.

    Args:
        name: Of the file in that folder.
        amount: On which the new result rests.
        full: On which a whole result rests, and one that does not say so; None: that is replaced.
    """
    path = PLACE / name
    if os.environ.get("FORCE") or not path.is_file():
        return PLACE
    before = _on_file(json.loads(path.read_text(encoding="utf-8")), full)
    if before is None or amount >= min(before, full or before):
        return PLACE
    print(f"{name} on file rests on {before:g}, this run on {amount:g}: written aside; FORCE=1")
    return ASIDE


def write_details(
    name: str, amount: float, data: Mapping[str, Any], full: float | None = None
) -> None:
    """Write what lies behind the figures of a part.

    Args:
        name: Of the file, such as "voice/near_taken.json".
        amount: On which it rests.
        data: For JSON.
        full: On which a whole result rests, as `measured` says; None: no result rests on more.
    """
    path = place(name, amount, full) / name
    path.parent.mkdir(parents=True, exist_ok=True)
    text = json.dumps({MEASURED: amount, **data}, indent=1)
    path.write_text(text + "\n", encoding="utf-8")


def _on_file(data: Mapping[str, Any], unsaid: float | None) -> float | None:
    if MEASURED in data:
        return float(data[MEASURED])
    values = (f["value"] for f in data.get("figures", ()) if f["name"] == MEASURED)
    return next(values, unsaid)

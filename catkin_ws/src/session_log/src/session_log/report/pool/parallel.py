# SPDX-License-Identifier: BSD-3-Clause
"""Applies a function to many items: in this process, or on cores and machines by dask."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from itertools import islice
from typing import Any, Generic, TypeVar

from session_log.errors import SessionLogError

T = TypeVar("T")
R = TypeVar("R")
AHEAD = 2  # items handed out per worker beyond those that are done
CONNECT_TIME = "10s"


class EngineMissing(SessionLogError):
    """Several workers were asked for, and dask.distributed is not installed."""

    def __init__(self) -> None:
        super().__init__(
            "more than one job needs dask.distributed, which is not installed: "
            "pip install -r requirements-bench.txt, or leave out --jobs and --cluster"
        )


class EngineUnreachable(SessionLogError):
    """There is no dask scheduler at the address."""

    def __init__(self, address: str, cause: Exception) -> None:
        super().__init__(f"no dask scheduler at {address!r}: {cause}")


@dataclass(frozen=True)
class Unfinished(Generic[T]):
    """An item without a value: its worker was killed or went away."""

    item: T
    reason: str


def run_parallel(
    function: Callable[[T], R], items: Iterable[T], jobs: int = 1, cluster: str = ""
) -> Iterator[R | Unfinished[T]]:
    """Yield the function's value for each item, in the order in which they are done.

    No more than a few items per worker are out at any time, so neither items nor values gather. A
    lost worker costs the items that it had, not the others.

    Args:
        function: Must be importable where the workers are.
        items: What to apply it to.
        jobs: Processes on this machine; 1 is this process.
        cluster: Address of a dask scheduler that is used instead; empty for none.

    Raises:
        EngineMissing: dask is needed and not installed.
        EngineUnreachable: There is no scheduler at the address.
    """
    if jobs <= 1 and not cluster:
        yield from map(function, items)
        return
    distributed = _engine()
    with _client(distributed, jobs, cluster) as client:
        yield from _flow(distributed, client, function, iter(items))


def _flow(
    distributed: Any, client: Any, function: Callable[[T], R], items: Iterator[T]
) -> Iterator[R | Unfinished[T]]:
    workers = max(sum(client.nthreads().values()), 1)
    out: dict[Any, T] = {}  # by future

    def submit(count: int) -> list[Any]:
        new = {client.submit(function, item, pure=False): item for item in islice(items, count)}
        out.update(new)
        return list(new)

    waiting = distributed.as_completed(
        submit(workers * AHEAD), with_results=True, raise_errors=False
    )
    for future, value in waiting:
        item, has_failed = out.pop(future), future.status in ("error", "cancelled")
        future.release()
        waiting.update(submit(1))
        yield Unfinished(item, _reason(value)) if has_failed else value


def _reason(failure: Any) -> str:
    """Why a future has no value: what as_completed gives for it."""
    error = failure[1] if isinstance(failure, tuple) else failure
    return f"{type(error).__name__}: {error}"


def _engine() -> Any:
    try:
        return importlib.import_module("distributed")
    except ImportError as error:
        raise EngineMissing from error


def _client(distributed: Any, jobs: int, cluster: str) -> Any:
    if cluster:
        try:
            return distributed.Client(cluster, timeout=CONNECT_TIME)
        except (OSError, ValueError) as error:
            raise EngineUnreachable(cluster, error) from error
    return distributed.Client(
        n_workers=jobs, threads_per_worker=1, processes=True, dashboard_address=None
    )

# SPDX-License-Identifier: BSD-3-Clause
"""Applies a function to many items: in this process, or on cores and machines by dask."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterable, Iterator
from itertools import islice
from typing import Any, TypeVar

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
        self.address = address


def run_parallel(
    function: Callable[[T], R], items: Iterable[T], jobs: int = 1, cluster: str = ""
) -> Iterator[R]:
    """Yield the function's value for each item, in the order in which they are done.

    No more than a few items per worker are out at any time, so neither items nor values gather.

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
) -> Iterator[R]:
    workers = max(sum(client.nthreads().values()), 1)

    def submit(count: int) -> list[Any]:
        return [client.submit(function, item, pure=False) for item in islice(items, count)]

    waiting = distributed.as_completed(submit(workers * AHEAD), with_results=True)
    for future, value in waiting:
        future.release()
        waiting.update(submit(1))
        yield value


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

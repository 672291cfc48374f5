# SPDX-License-Identifier: BSD-3-Clause
"""The decorator of the core's compiled functions, with a cache on disk that is never stale.

Numba looks only at the file of a function to judge whether its cached code is still good, not at
the files of the functions it calls. So when the source of any kernel here has changed since, the
cached code of all of them is thrown away.

Code lies beside its source, where set-up compiles it. An account that may not write there reads it.
What it has to compile itself goes to its own cache folder. Without a home it is compiled each time.
"""

from __future__ import annotations

import hashlib
import importlib
import os
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

from numba import njit
from numba.core.caching import (
    CompileResultCacheImpl,
    FunctionCache,
    IndexDataCacheFile,
    InTreeCacheLocator,
)
from numba.np import linalg

Function = TypeVar("Function", bound=Callable[..., Any])
SOURCES = Path(__file__).parent
STAMP = SOURCES / "__pycache__" / "kernels.stamp"


def _load_without_blas() -> None:
    """Import numba's functions of arrays without scipy.linalg, in which they look for BLAS.

    That import is a fifth of a node's start. No kernel multiplies matrices by BLAS; one that did
    would not compile.
    """

    def find_none() -> None:
        raise ImportError("kernels do without BLAS")

    found, linalg.ensure_blas = linalg.ensure_blas, find_none
    try:
        importlib.import_module("numba.np.arraymath")
    finally:
        linalg.ensure_blas = found


_load_without_blas()


def kernel(function: Function, error_model: str = "python") -> Function:
    """Compile a function when it is first called, and keep its code on disk."""
    # without the GIL: the control loop ticks beside it
    compiled: Any = njit(nogil=True, error_model=error_model)(function)
    compiled._cache = _KernelCache(function)
    result: Function = compiled
    return result


@cache
def drop_stale_code() -> tuple[str, bool]:
    """Delete cached code of the package if any of its sources differs from when it was written.

    Returns:
        The digest of the sources, and whether the code beside them may be used.
    """
    now = _digest(sorted(SOURCES.rglob("*.py")))
    try:
        if STAMP.is_file() and STAMP.read_text(encoding="ascii") == now:
            return now, True
        for old in SOURCES.rglob("__pycache__/*.nb[ic]"):
            old.unlink(missing_ok=True)
        STAMP.parent.mkdir(exist_ok=True)
        STAMP.write_text(now, encoding="ascii")
    except OSError:
        return now, False  # the sources cannot be written to
    return now, True


def _digest(files: list[Path]) -> str:
    digest = hashlib.sha256()
    for file in files:
        source = file.read_bytes()
        if b"@kernel" in source or b"@partial(kernel" in source:
            digest.update(file.name.encode() + source)
    return digest.hexdigest()


class _BesideSource(InTreeCacheLocator):
    @classmethod
    def from_function(cls, py_func: Any, py_file: str) -> _BesideSource:
        """Locate the folder, which need not be writable."""
        return cls(py_func, py_file)


class _BesideSourceImpl(CompileResultCacheImpl):
    _locator_classes = [_BesideSource]  # noqa: RUF012  # as its base declares it


class _KernelCache(FunctionCache):
    """Reads code from beside the source and from the account's cache; writes it where it may."""

    _impl_class = _BesideSourceImpl

    def __init__(self, function: Callable[..., Any]) -> None:
        super().__init__(function)
        digest, good = drop_stale_code()
        self._files = [self._cache_file] if good else []
        try:
            self._impl.locator.ensure_cache_path()
        except OSError:  # may not be written
            if home := _account_cache():
                room = Path(self._cache_path).parent.name
                self._keep_in(home / "rst_control" / digest[:16] / room)

    def _keep_in(self, folder: Path) -> None:
        self._impl.locator._cache_path = str(folder)
        stamp = self._impl.locator.get_source_stamp()
        self._files.append(IndexDataCacheFile(str(folder), self._impl.filename_base, stamp))

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the compiled code of a signature, or None."""
        for file in self._files:
            self._cache_file = file  # the last one is written to
            try:
                found = super().load_overload(sig, target_context)
            except OSError:  # of another account, and closed to this one
                continue
            if found is not None:
                return found
        return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep compiled code. What cannot be kept, on a full disk or without a home, is not."""
        try:
            if self._files:
                super().save_overload(sig, data)
        except OSError:
            pass


def _account_cache() -> Path | None:
    try:
        return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    except RuntimeError:  # an account without an entry or a home
        return None

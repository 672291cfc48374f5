# SPDX-License-Identifier: BSD-3-Clause
"""Names of cached files by what they were made of, and what two runs were asked for."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Set
from dataclasses import fields, is_dataclass
from pathlib import Path

import numpy as np


def digest(*inputs: object) -> str:
    """SHA-256 of values, hexadecimal.

    Args:
        inputs: Plain values and arrays, and collections and dataclasses of them. What is written
            alike counts as the same.
    """
    found = hashlib.sha256()
    _feed(found, inputs)
    return found.hexdigest()


def keyed(path: Path, *inputs: object) -> Path:
    """The path of a cached file, with a digest of all that it is made of in its name."""
    return path.with_name(f"{path.stem}_{digest(*inputs)[:16]}{path.suffix}")


def differences(kept: object, asked: Mapping[str, object]) -> str:
    """In what a run was asked for something else than now; empty where in nothing.

    Args:
        kept: What its file says, by name; no mapping where the file is of an earlier version.
        asked: What is asked for now, by name.
    """
    if not isinstance(kept, Mapping):
        return "options that it does not say"
    names = [name for name in {**kept, **asked} if kept.get(name) != asked.get(name)]
    return ", ".join(f"{name} {kept.get(name)} (now {asked.get(name)})" for name in names)


def _feed(found: hashlib._Hash, value: object) -> None:
    if isinstance(value, np.ndarray):
        found.update(f"{value.dtype} {value.shape} ".encode())
        found.update(value.tobytes())
    elif isinstance(value, list | tuple):
        found.update(f"{type(value).__name__} {len(value)} ".encode())
        for part in value:
            _feed(found, part)
    elif isinstance(value, Mapping):
        _feed(found, list(value.items()))
    elif isinstance(value, Set):
        _feed(found, sorted(map(repr, value)))  # whose order is another in each process
    elif is_dataclass(value):
        found.update(f"{type(value).__name__} ".encode())
        for field in fields(value):
            _feed(found, getattr(value, field.name))
    else:
        found.update(f"{value!r} ".encode())

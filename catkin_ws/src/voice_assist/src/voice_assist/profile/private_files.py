# SPDX-License-Identifier: BSD-3-Clause
"""Files that only their owner may read, written all or nothing, by one process at a time."""

from __future__ import annotations

import fcntl
import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

FOLDER, FILE = 0o700, 0o600  # permissions


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Lock a folder against every other caller of this function, in any process.

    The lock is on the folder itself, so it needs no file.

    Raises:
        OSError: The folder is gone, or cannot be locked.
    """
    handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX)
        yield
    finally:
        os.close(handle)


def write(path: Path, data: bytes) -> None:
    """Write all or nothing, and let it reach the disk.

    Raises:
        OSError: It cannot be written.
    """
    unfinished = path.with_name(f".{path.name}.tmp")
    path.parent.mkdir(mode=FOLDER, exist_ok=True)
    unfinished.unlink(missing_ok=True)
    handle = os.open(unfinished, os.O_WRONLY | os.O_CREAT | os.O_EXCL, FILE)
    with os.fdopen(handle, "wb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())
    unfinished.replace(path)


def read(path: Path) -> bytes:
    """Read a plain file that nobody else may read.

    Raises:
        OSError: There is none, others may read it, or it cannot be read; its text names the path.
    """
    if not path.is_file() or path.is_symlink():
        raise OSError(f"{path} is missing, or no plain file")
    require_private(path, FILE)
    try:
        return path.read_bytes()
    except OSError as error:
        raise OSError(f"{path}: {error.strerror}") from error


def require_private(path: Path, allowed: int) -> None:
    """Refuse what others may read or change.

    Raises:
        OSError: Says which permissions it has, and which are allowed.
    """
    mode = stat.S_IMODE(path.stat().st_mode)
    if mode & 0o077:
        says = f"has the permissions {mode:04o}, allowed: {allowed:04o} (chmod {allowed:o})"
        raise OSError(f"{path} {says}; recordings are private")

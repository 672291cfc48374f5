# SPDX-License-Identifier: BSD-3-Clause
"""Deleting a profile, readable or not; a folder that holds something else is refused."""

from __future__ import annotations

import shutil
from pathlib import Path

from voice_assist.config.profile import require_name
from voice_assist.profile.profile import (
    MANIFEST,
    TAKES,
    VoiceProfileError,
    missing_profile,
    require_profile,
)


def folder_to_delete(name: str, root: Path) -> Path:
    """Folder of a profile, readable or not.

    Raises:
        ConfigError: The name cannot be used.
        VoiceProfileError: There is none, or the folder of that name holds something else.
    """
    require_name(name)
    folder = root / name
    if folder.is_symlink() or not folder.is_dir():
        raise missing_profile(name, root)
    require_profile(folder)
    return folder


def delete_profile(name: str, root: Path) -> int:
    """Remove all that a profile holds; gives how many files that were.

    What shows that it is a profile goes last. So one that was removed in part can be deleted.

    Raises:
        ConfigError: The name cannot be used.
        VoiceProfileError: As `folder_to_delete`, or something of it cannot be removed.
    """
    folder = folder_to_delete(name, root)
    count = sum(path.is_file() for path in folder.rglob("*"))
    try:
        for path in sorted(folder.iterdir(), key=lambda path: path.name in (MANIFEST, TAKES)):
            if path.is_dir() and not path.is_symlink():
                shutil.rmtree(path)
            else:
                path.unlink()
        folder.rmdir()
    except OSError as error:
        raise VoiceProfileError(f"{folder} cannot be removed whole: {error}") from error
    return count

# SPDX-License-Identifier: BSD-3-Clause
"""Errors of the recording package; each names the file and what is wrong with it."""

from __future__ import annotations

from pathlib import Path


class SessionLogError(Exception):
    """Base of every error that this package raises."""


class SessionMissing(SessionLogError):
    """There is no recording where one was named."""

    def __init__(self, path: Path, why: str) -> None:
        super().__init__(f"{path}: {why}")
        self.path = path


class NotASession(SessionLogError):
    """The file exists but is not an MCAP recording."""

    def __init__(self, path: Path, found: str) -> None:
        is_damaged = path.suffix == ".mcap" and found.startswith("begins")  # an empty one is lost
        help_ = ", `session_log recover` may help" if is_damaged else ""
        super().__init__(f"{path} is not an MCAP recording: it {found}{help_}")
        self.path = path


class RecordingFailed(SessionLogError):
    """What was received cannot be written now; it is kept and tried again."""

    def __init__(self, path: Path, cause: OSError) -> None:
        words = cause.strerror or type(cause).__name__
        super().__init__(f"cannot record to {path}: {words}")
        self.path, self.cause = path, cause


class OutputFailed(SessionLogError):
    """A report, an export or a recovered copy cannot be written."""

    def __init__(self, path: Path, cause: OSError) -> None:
        super().__init__(f"cannot write {path}: {cause.strerror or type(cause).__name__}")
        self.path, self.cause = path, cause

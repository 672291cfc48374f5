# SPDX-License-Identifier: BSD-3-Clause
"""profile.json: what a profile holds, take by take and file by file, each with its check sum."""

from __future__ import annotations

import json
import re
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any, TypeVar

from typed_config import ConfigError, choice, integer, items, load_config, number, require, text
from voice_assist.config.profile import require_name
from voice_assist.errors import VoiceError

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

T = TypeVar("T")
FORMAT = 1
LARGEST = 4_000_000  # [B] of the manifest: thousands of takes
_FILE = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,79}")
_TAKE_FILE = re.compile(r"takes/[0-9]{4}\.wav")
_SHA256 = re.compile(r"[0-9a-f]{64}")

RECORDING, ACTIVE, REFUSED = "recording", "active", "refused"
COMMAND, TALK, ROOM = "command", "talk", "room"


@dataclass(frozen=True, kw_only=True)
class Take:
    """One recording that the person made."""

    file: str = text()  # in the profile's folder
    sha256: str = text()  # of the file
    kind: str = choice(COMMAND, TALK, ROOM)
    phrase: str = text(may_be_empty=True)  # of a command
    time: str = text()  # when it was recorded or taken over, UTC, ISO 8601
    source: str = text()  # microphone, or the name of the recording it was cut from
    seconds: float = number(0.0, 3600.0, "s")
    level_db: float = number(-100.0, 20.0, "dB")  # of the speech, of full scale
    snr_db: float = number(-100.0, 200.0, "dB")  # of the speech over the quiet around it
    heard: str = text(may_be_empty=True)  # by the base model
    verdict: str = text()  # "good", or what is odd about it though it was kept

    def __post_init__(self) -> None:
        """Check what no key shows alone."""
        where = bool(_TAKE_FILE.fullmatch(self.file))
        require(where, "file", self.file, "takes/NNNN.wav")
        is_sum = bool(_SHA256.fullmatch(self.sha256))
        require(is_sum, "sha256", self.sha256, "64 hexadecimal digits")
        is_named = bool(self.phrase) == (self.kind == COMMAND)
        require(is_named, "phrase", self.phrase, "a phrase for a command, and none otherwise")


@dataclass(frozen=True, kw_only=True)
class File:
    """One other file of the profile."""

    name: str = text()
    sha256: str = text()

    def __post_init__(self) -> None:
        """Check what no key shows alone."""
        is_plain = bool(_FILE.fullmatch(self.name)) and self.name != "profile.json"
        require(is_plain, "name", self.name, "a plain file name other than profile.json")
        is_sum = bool(_SHA256.fullmatch(self.sha256))
        require(is_sum, "sha256", self.sha256, "64 hexadecimal digits")


@dataclass(frozen=True, kw_only=True)
class Manifest:
    """All of profile.json."""

    format: int = integer(FORMAT, FORMAT)
    name: str = text()
    created: str = text()  # UTC, ISO 8601
    base_sha256: str = text()  # of the recogniser that it was made on top of
    state: str = choice(RECORDING, ACTIVE, REFUSED)
    why: tuple[str, ...] = text()  # it was refused
    takes: tuple[Take, ...] = items(0, 5000)
    files: tuple[File, ...] = items(0, 50)

    def __post_init__(self) -> None:
        """Check what no key shows alone."""
        require_name(self.name)
        is_sum = bool(_SHA256.fullmatch(self.base_sha256))
        require(is_sum, "base_sha256", self.base_sha256, "64 hexadecimal digits")
        for key, names in (
            ("takes", [take.file for take in self.takes]),
            ("files", [file.name for file in self.files]),
        ):
            twice = sorted({name for name in names if names.count(name) > 1})
            require(not twice, key, twice, "each file named once")
        explained = bool(self.why) == (self.state == REFUSED)
        require(explained, "why", list(self.why), "reasons if it is refused, none otherwise")

    def sum_of(self, name: str) -> str | None:
        """SHA-256 that a file must have; None: the profile has no such file."""
        sums = {file.name: file.sha256 for file in self.files}
        sums |= {take.file: take.sha256 for take in self.takes}
        return sums.get(name)


def read_part(kind: type[T], data: bytes, name: str) -> T:
    """A file of JSON in a profile.

    Raises:
        VoiceError: It is something else.
    """
    try:
        return load_config(kind, json.loads(data), name)
    except (ConfigError, ValueError, RecursionError) as error:
        raise VoiceError(f"{name} of the profile cannot be used: {error}") from error


def to_bytes(part: DataclassInstance) -> bytes:
    """The manifest or another part of a profile, as its file of JSON holds it."""
    return (json.dumps(asdict(part), indent=1, allow_nan=False) + "\n").encode()


def from_bytes(data: bytes, where: str) -> Manifest:
    """The manifest that `to_bytes` gave.

    Args:
        data: Of the file.
        where: Names it in errors.

    Raises:
        ValueError: It is no JSON.
        ConfigError: A key is not as it must be.
    """
    if len(data) > LARGEST:
        raise ValueError(f"{len(data)} bytes, allowed: up to {LARGEST}")
    found: Any = json.loads(data)
    return load_config(Manifest, found, where)

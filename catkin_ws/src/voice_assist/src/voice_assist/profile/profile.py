# SPDX-License-Identifier: BSD-3-Clause
"""One person's profile: a folder that only its owner may read, and whose every byte is checked.

In it lie `profile.json`, which names all else with its SHA-256 and is written last, all or nothing;
`takes/NNNN.wav`, what the person said (16 bit, 16 kHz, mono); and what was made of it, such as the
adapted weights. Folders have the permissions 0700, files 0600.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

from typed_config import ConfigError
from voice_assist.config.profile import NAME, NOBODY, require_name
from voice_assist.errors import VoiceError
from voice_assist.profile import private_files
from voice_assist.profile.manifest import (
    FORMAT,
    RECORDING,
    File,
    Manifest,
    Take,
    from_bytes,
    to_bytes,
)
from voice_assist.profile.take_sound import from_wav, to_wav
from voice_assist.types import Samples

if TYPE_CHECKING:
    from voice_assist.recognizer.recognizer import Recognizer

ENV = "VOICE_ASSIST_PROFILES"
MANIFEST, TAKES = "profile.json", "takes"
_LEFTOVER = f".{MANIFEST}.tmp"  # of a profile that was not made to its end


class VoiceProfileError(VoiceError):
    """A profile is missing, damaged, open to others, or of something else."""


def profiles_folder(given: str | Path | None = None) -> Path:
    """Folder of all profiles: as given, as the environment says, or in the user's own data.

    Raises:
        VoiceProfileError: It is in the home of a user who has none, or a file.
    """
    data = os.environ.get("XDG_DATA_HOME") or "~/.local/share"
    folder = given or os.environ.get(ENV) or f"{data}/voice_assist/profiles"
    try:
        path = Path(folder).expanduser()
        if path.exists() and not path.is_dir():
            raise NotADirectoryError("it is no folder")
    except (RuntimeError, OSError) as error:
        allowed = f"allowed in profile.folder or {ENV}: a folder that exists or can be made"
        why = getattr(error, "strerror", None) or error
        raise VoiceProfileError(f"profiles in {str(folder)!r}: {why}; {allowed}") from error
    return path


class VoiceProfile:
    """A profile's folder, and what its manifest says."""

    def __init__(self, folder: Path, manifest: Manifest, manifest_digest: str) -> None:
        """Use `open_profile` or `create_profile`."""
        self.folder, self.manifest = folder, manifest
        self.manifest_digest = manifest_digest  # SHA-256 of it, and so of all that is held

    @property
    def name(self) -> str:
        """As the person was called."""
        return self.manifest.name

    @property
    def digest(self) -> str:
        """SHA-256 of what hearing uses; takes may be added meanwhile, and do not change it."""
        manifest = self.manifest
        sums = sorted((file.name, file.sha256) for file in manifest.files)
        return _digest(json.dumps([manifest.name, manifest.base_sha256, sums]).encode())

    def add_take(self, samples: Samples, take: Take) -> Take:
        """Keep a recording.

        Args:
            samples: float32 in [-1, 1], 16 kHz mono. Shape (n,).
            take: What is known of it; file and check sum are filled in here.

        Returns:
            The take as it is on file.

        Raises:
            VoiceProfileError: It cannot be written, or could not be read again.
        """
        data = to_wav(samples)
        with self._newest() as manifest:
            used = [int(take.file[6:10]) for take in manifest.takes]
            name = f"{TAKES}/{max(used, default=0) + 1:04d}.wav"
            take = replace(take, file=name, sha256=_digest(data))
            self._save(replace(manifest, takes=(*manifest.takes, take)), (name, data))
        return take

    def put(self, name: str, data: bytes) -> None:
        """Write a file of the profile, in place of one of that name.

        Raises:
            VoiceProfileError: It cannot be written.
            ConfigError: The name is no plain file name.
        """
        file = File(name=name, sha256=_digest(data))
        with self._newest() as manifest:
            others = tuple(f for f in manifest.files if f.name != name)
            self._save(replace(manifest, files=(*others, file)), (name, data))

    def drop(self, name: str) -> None:
        """Remove a file of the profile, if it has one of that name."""
        with self._newest() as manifest:
            if self.has(name):
                others = tuple(f for f in manifest.files if f.name != name)
                self._save(replace(manifest, files=others))
                (self.folder / name).unlink(missing_ok=True)

    def judge(self, state: str, why: tuple[str, ...] = ()) -> None:
        """Activate or refuse it.

        Args:
            state: RECORDING, ACTIVE or REFUSED of the manifest.
            why: Reasons of a refusal.

        Raises:
            VoiceProfileError: It cannot be written, or could not be read again.
            ConfigError: Reasons are missing, or are none of a refusal.
        """
        with self._newest() as manifest:
            self._save(replace(manifest, state=state, why=why))

    def rebase(self, base_sha256: str) -> None:
        """Note on top of which recogniser the profile is made from now on."""
        with self._newest() as manifest:
            self._save(replace(manifest, base_sha256=base_sha256))

    def has(self, name: str) -> bool:
        """Whether the manifest names such a file."""
        return any(file.name == name for file in self.manifest.files)

    def read(self, name: str) -> bytes:
        """A file of the profile, compared with its check sum.

        Raises:
            VoiceProfileError: The profile has none of that name, or it is not as it was written.
        """
        expected = self.manifest.sum_of(name)
        if expected is None:
            names = ", ".join(file.name for file in self.manifest.files) or "none"
            raise VoiceProfileError(f"profile {self.name!r} has no file {name!r}, only: {names}")
        data = _read_own(self.folder / name, self.name)
        if (found := _digest(data)) != expected:
            says = f"has the SHA-256 {found[:12]}, allowed: {expected[:12]}"
            raise VoiceProfileError(
                f"profile {self.name!r}: {name} {says}; it was changed or damaged"
            )
        return data

    def sound(self, take: Take) -> Samples:
        """What was said in a take. Shape (n,), read-only.

        Raises:
            VoiceProfileError: The file is not as it was written.
        """
        data = self.read(take.file)
        try:
            return from_wav(data)
        except ValueError as error:
            raise VoiceProfileError(f"profile {self.name!r}: {take.file}: {error}") from error

    def check(self) -> None:
        """Read every byte of it once.

        Raises:
            VoiceProfileError: Something is missing, damaged or open to others.
        """
        takes = [take.file for take in self.manifest.takes]
        for name in [*takes, *(file.name for file in self.manifest.files)]:
            self.read(name)

    @contextmanager
    def _newest(self) -> Iterator[Manifest]:
        """The manifest on file, to be changed: another process may have added to it meanwhile."""
        try:
            with private_files.locked(self.folder):
                self.manifest, self.manifest_digest = _read_manifest(self.folder, self.name)
                yield self.manifest
        except OSError as error:
            words = f"{self.folder} cannot be written: {error.strerror}"
            raise VoiceProfileError(words) from error

    def _save(self, manifest: Manifest, *files: tuple[str, bytes]) -> None:
        """Write files, then the manifest that names them; none if it could not be read again."""
        try:
            data = to_bytes(manifest)
            from_bytes(data, MANIFEST)
        except ValueError as error:
            words = f"{MANIFEST} is not written, as nobody could read it: {error}"
            raise VoiceProfileError(f"profile {manifest.name!r}: {words}") from error
        for name, content in (*files, (MANIFEST, data)):
            path = self.folder / name
            try:
                private_files.write(path, content)
            except OSError as error:
                raise VoiceProfileError(f"{path} cannot be written: {error.strerror}") from error
        self.manifest, self.manifest_digest = manifest, _digest(data)


def create_profile(name: str, base_sha256: str, root: Path) -> VoiceProfile:
    """Make an empty profile; a folder of that name is used for it if it is empty.

    What is left in it of a profile that was not made to its end does not count.

    Args:
        name: Of the person.
        base_sha256: Of the recogniser on top of which it is made.
        root: Folder of all profiles; made if missing, for its owner alone.

    Raises:
        ConfigError: The name cannot be used.
        VoiceProfileError: There is one of that name, the folder holds something else, or it cannot
            be written.
    """
    require_name(name)
    folder = root / name
    try:
        root.mkdir(mode=private_files.FOLDER, parents=True, exist_ok=True)
        _remove_unfinished(folder)
        folder.mkdir(mode=private_files.FOLDER)
    except FileExistsError as error:
        require_profile(folder)
        raise VoiceProfileError(f"profile {name!r} exists already in {root}") from error
    except OSError as error:
        raise VoiceProfileError(f"{folder} cannot be made: {error.strerror}") from error
    manifest = Manifest(
        format=FORMAT,
        name=name,
        created=now(),
        base_sha256=base_sha256,
        state=RECORDING,
        why=(),
        takes=(),
        files=(),
    )
    profile = VoiceProfile(folder, manifest, "")
    try:
        profile._save(manifest)
    finally:
        _remove_unfinished(folder)
    return profile


def open_profile(name: str, root: Path) -> VoiceProfile:
    """Open a profile; its files are checked as they are read, all of them by `check`.

    Raises:
        ConfigError: The name cannot be used.
        VoiceProfileError: It is missing, damaged, open to others, or the profile of somebody else.
    """
    require_name(name)
    folder = root / name
    if not folder.is_dir():
        raise missing_profile(name, root)
    return VoiceProfile(folder, *_read_manifest(folder, name))


def names(root: Path) -> list[str]:
    """All profiles of a folder whose names can be used, sorted."""
    found = (path.parent.name for path in root.glob(f"*/{MANIFEST}"))
    return sorted(name for name in found if NAME.fullmatch(name) and name != NOBODY)


def missing_profile(name: str, root: Path) -> VoiceProfileError:
    """The error where a folder has no profile of a name; names those that it has."""
    known = ", ".join(names(root)) or "none"
    return VoiceProfileError(f"no profile {name!r} in {root}, there: {known}")


def require_profile(folder: Path) -> None:
    """Refuse what is no profile, not even a damaged or unfinished one.

    Raises:
        VoiceProfileError: It is a folder that holds other files, and neither a manifest nor takes.
    """
    there = {path.name for path in folder.iterdir()} if folder.is_dir() else set()
    if there - {_LEFTOVER} and there.isdisjoint((MANIFEST, TAKES)):
        found = f"holds {min(there - {_LEFTOVER})!r} and no profile"
        allowed = f"allowed: a folder with {MANIFEST} or {TAKES}/ in it, or an empty one"
        raise VoiceProfileError(f"{folder} {found}, {allowed}")


def take_digest(samples: Samples) -> str:
    """Check sum that a take of this sound has on file."""
    return _digest(to_wav(samples))


def facts_of(recognizer: Recognizer) -> dict[str, str]:
    """What a recording says of the profile in use; nothing where the base alone hears."""
    name, digest = getattr(recognizer, "profile", ""), getattr(recognizer, "profile_digest", "")
    return {"profile": name, "profile_sha256": digest} if digest else {}


def now() -> str:
    """Time of a take, UTC, to the second."""
    return datetime.now(UTC).isoformat(timespec="seconds")


def _digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


def _read_manifest(folder: Path, name: str) -> tuple[Manifest, str]:
    """What the manifest of a person's profile says, and its check sum."""
    try:
        private_files.require_private(folder, private_files.FOLDER)
    except OSError as error:
        raise VoiceProfileError(f"profile {name!r}: {error}") from error
    data = _read_own(folder / MANIFEST, name)
    try:
        manifest = from_bytes(data, MANIFEST)
    except (ConfigError, ValueError, RecursionError) as error:
        raise VoiceProfileError(f"profile {name!r}: {MANIFEST} is damaged: {error}") from error
    if manifest.name != name:
        raise VoiceProfileError(f"profile {name!r}: {MANIFEST} is that of {manifest.name!r}")
    return manifest, _digest(data)


def _read_own(path: Path, name: str) -> bytes:
    try:
        return private_files.read(path)
    except OSError as error:
        raise VoiceProfileError(f"profile {name!r}: {error}") from error


def _remove_unfinished(folder: Path) -> None:
    """Remove the folder of a profile that was not made to its end; any other stays."""
    with suppress(OSError):
        (folder / _LEFTOVER).unlink(missing_ok=True)
        folder.rmdir()

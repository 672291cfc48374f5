# SPDX-License-Identifier: BSD-3-Clause
"""Facts about a session that its messages do not hold: code, machine, versions, settings."""

from __future__ import annotations

import hashlib
import json
import os
import platform
import re
import subprocess
from collections.abc import Iterable, Mapping
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any
from xmlrpc.client import Binary

import yaml

PARAMETERS = "parameters"  # metadata record with the parameter server, one YAML text per key
PACKAGES = ("numpy", "torch", "openai-whisper", "pybullet", "ruckig", "mcap", "matplotlib")
HASHED_SUFFIX = "_sha256"
NOT_RECORDED = "# not recorded: "  # begins the text of a parameter that cannot be written
_PLAIN = (bool, int, float, str, bytes)  # what YAML holds, beside lists and mappings


def code_facts(sources: Path | None) -> dict[str, str]:
    """Name the git commit of the repository that tracks the sources, and what was changed since.

    A repository that tracks none of them is not theirs: a whole home may be kept in git.
    Without a repository, as in the image, the commit is that of VOICE_ASSIST_COMMIT.
    What is not known is "unknown".

    Args:
        sources: Folder of a package in its sources; None in an install space, which has none.
    """
    if sources and _git(sources, "ls-files") and (commit := _git(sources, "rev-parse", "HEAD")):
        changed = _git(sources, "status", "--porcelain")
        return {"commit": commit, "changed_files": "unknown" if changed is None else changed}
    built = os.environ.get("VOICE_ASSIST_COMMIT")
    return {"commit": built or "unknown", "changed_files": "" if built else "unknown"}


def machine_facts() -> dict[str, str]:
    """Name the machine, its system and its processor."""
    return {
        "host": platform.node(),
        "system": platform.platform(),
        "processor": _processor(),
        "cores": str(os.cpu_count()),
        "memory_bytes": str(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")),
        "python": platform.python_version(),
    }


def version_facts(packages: Iterable[str] = PACKAGES) -> dict[str, str]:
    """Name the installed version of each package; those that are not installed are left out."""
    found = {}
    for package in packages:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            continue
    return found


def session_facts(started: int, seed: int) -> dict[str, str]:
    """Name when the session started ([ns] since 1970) and its random seed."""
    time = datetime.fromtimestamp(started * 1e-9, tz=UTC)
    return {"started": time.isoformat(timespec="milliseconds"), "seed": str(seed)}


def parameter_facts(parameters: Mapping[str, Any]) -> dict[str, str]:
    """Flatten the parameter server into one YAML text per top-level key; the URDF is kept apart.

    Binary data stay so. Other types that YAML does not hold, such as dates, become text. A key
    that cannot be written at all has NOT_RECORDED and the reason in place of its value.
    """
    return {
        key: _yaml(value) for key, value in sorted(parameters.items()) if key != "robot_description"
    }


def content(value: Any) -> str:
    """A text that tells two values of the parameter server apart, made in little time."""
    return json.dumps(value, sort_keys=True, default=_told)


def settings_at(parameters: Mapping[str, str], path: str) -> Mapping[str, Any]:
    """The part of recorded parameters at a path such as `/robot_1/voice_assist`; empty: none.

    Args:
        parameters: As `parameter_facts` made them.
        path: Keys with slashes between them.
    """
    first, *rest = [part for part in re.split("/+", path) if part] or [""]
    try:
        branch: Any = yaml.safe_load(parameters.get(first, ""))
    except yaml.YAMLError:
        return {}
    for part in rest:
        branch = branch.get(part) if isinstance(branch, dict) else None
    return branch if isinstance(branch, dict) else {}


def named_facts(facts: Mapping[str, Any]) -> dict[str, str]:
    """Turn what a node says about itself into text; a named file gets its hash beside it."""
    words = {str(key): str(value) for key, value in facts.items()}
    for key, value in list(words.items()):
        if _is_file(value) and key + HASHED_SUFFIX not in words:
            words[key + HASHED_SUFFIX] = file_hash(Path(value))
    return words


def file_hash(path: Path) -> str:
    """SHA-256 of a file, in hexadecimal; empty if it cannot be read."""
    try:
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError:
        return ""


def _yaml(value: Any) -> str:
    try:
        return yaml.safe_dump(_plain(value), default_flow_style=False, width=120).strip()
    except Exception as error:  # whatever is wrong with one key must not cost the others
        reason = " ".join(str(error).split())  # on one line, or it would be no comment
        return f"{NOT_RECORDED}{type(error).__name__}: {reason}"


def _told(value: Any) -> str:
    """What JSON cannot hold, such as dates and binary data, as text."""
    try:
        return value.data.hex() if isinstance(value, Binary) else str(value)
    except Exception:  # as in `_yaml`
        return type(value).__name__


def _plain(value: Any) -> Any:
    """A parameter in types that YAML holds; XML-RPC also carries dates and binary data."""
    if isinstance(value, Mapping):
        return {str(key): _plain(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(entry) for entry in value]
    if isinstance(value, Binary):
        return value.data
    if value is None or type(value) in _PLAIN:
        return value
    return str(value)


def _is_file(words: str) -> bool:
    path = Path(words)
    try:
        return path.is_absolute() and path.is_file()
    except OSError:  # too long for a path
        return False


def _git(folder: Path, *words: str) -> str | None:
    """What git answers; None where it fails or takes too long."""
    try:
        done = subprocess.run(
            ["git", "-C", str(folder), *words],
            capture_output=True,
            text=True,
            timeout=5.0,
            check=True,
        )
    except (OSError, subprocess.SubprocessError):
        return None
    return done.stdout.strip()


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor()
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()

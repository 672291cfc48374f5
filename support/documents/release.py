# SPDX-License-Identifier: BSD-3-Clause
"""`python -m support.documents.release 1.0.0`: writes the version wherever it stands.

pyproject.toml is the place to read it. The manifests of the packages, CITATION.cff and the heading
of the changelog follow.
"""

from __future__ import annotations

import argparse
import re
import tomllib
from datetime import UTC, datetime
from pathlib import Path
from typing import Final

ROOT: Final = Path(__file__).resolve().parents[2]
PACKAGES: Final = ("voice_assist", "rst_control", "session_log", "typed_config")
VERSION: Final = re.compile(r"\d+\.\d+\.\d+")
UNRELEASED: Final = "## [Unreleased]\n"


def places(root: Path = ROOT) -> dict[Path, re.Pattern[str]]:
    """Each file that bears the version, and the pattern of which it is the second group."""
    manifest = re.compile(r"(<version>)([^<]*)(</version>)")
    return {
        root / "pyproject.toml": re.compile(r'(^version = ")([^"]*)(")', re.MULTILINE),
        root / "CITATION.cff": re.compile(r"(^version: )(\S+)()", re.MULTILINE),
        **{root / "catkin_ws" / "src" / p / "package.xml": manifest for p in PACKAGES},
    }


def version(root: Path = ROOT) -> str:
    """The version of this repository."""
    with (root / "pyproject.toml").open("rb") as file:
        return str(tomllib.load(file)["project"]["version"])


def release(new: str, day: str, root: Path = ROOT) -> None:
    """Write a version everywhere, and date the changelog's unreleased part by it.

    Args:
        new: The version.
        day: Of the release, as 2026-12-01.
        root: Of the repository.

    Raises:
        ValueError: The changelog has no unreleased part.
    """
    changelog = root / "CHANGELOG.md"
    text = changelog.read_text(encoding="utf-8")
    if UNRELEASED not in text:
        raise ValueError(f"{changelog} has no line {UNRELEASED.strip()!r}")
    heading = f"{UNRELEASED}\n## [{new}] - {day}\n"
    changelog.write_text(text.replace(UNRELEASED, heading, 1), encoding="utf-8")
    for file, pattern in places(root).items():
        text = file.read_text(encoding="utf-8")
        changed = pattern.sub(lambda found: found[1] + new + found[3], text, count=1)
        file.write_text(changed, encoding="utf-8")


def main() -> None:
    """Take the version from the command line."""
    parser = argparse.ArgumentParser(prog="support.documents.release", description=__doc__)
    parser.add_argument("version", help="such as 1.0.0")
    new = parser.parse_args().version
    if not VERSION.fullmatch(new):
        parser.error(f"{new!r}, allowed: three numbers, such as 1.0.0")
    release(new, datetime.now(UTC).date().isoformat())
    print(f"{version()}: read the changelog, then commit and tag it")


if __name__ == "__main__":
    main()

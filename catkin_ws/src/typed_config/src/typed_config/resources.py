# SPDX-License-Identifier: BSD-3-Clause
"""Where the files of a catkin package lie: in its source folder, or in an install space's share."""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

MANIFEST = "package.xml"


class ResourceMissing(LookupError):
    """A package's folder or one of its files was not found."""

    def __init__(self, package: str, wanted: str, looked: tuple[Path, ...]) -> None:
        where = ", ".join(map(str, looked)) or "no folder"
        super().__init__(f"{wanted} of the package {package} was not found; searched: {where}")
        self.package, self.wanted, self.looked = package, wanted, looked


def package_folder(package: str) -> Path:
    """The folder with a package's package.xml, config, launch and other files.

    That is the package's folder in a source tree, from a devel space too, and
    `<prefix>/share/<package>` in an install space.

    Raises:
        ResourceMissing: The Python package is not that of a catkin package.
    """
    candidates = tuple(dict.fromkeys(_candidates(package)))
    for folder in candidates:
        if (folder / MANIFEST).is_file():
            return folder
    raise ResourceMissing(package, MANIFEST, candidates)


def package_file(package: str, file: str) -> Path:
    """A file of a package by its path below the package's folder, such as "config/rcm.yaml".

    Raises:
        ResourceMissing: It is not there.
    """
    folder = package_folder(package)
    if not (folder / file).is_file():
        raise ResourceMissing(package, file, (folder,))
    return folder / file


def package_version(package: str) -> str:
    """The version in a package's package.xml.

    Raises:
        ResourceMissing: There is no such package, or its package.xml names no version.
    """
    manifest = package_file(package, MANIFEST)
    version = ElementTree.parse(manifest).findtext("version", "").strip()
    if not version:
        raise ResourceMissing(package, "the version", (manifest,))
    return version


def repository(package: str) -> Path | None:
    """The folder that holds the catkin workspace of a package; None in an install space."""
    folder = package_folder(package)
    return folder.parents[2] if folder.parent.name == "src" else None


def _candidates(package: str) -> Iterator[Path]:
    """Folders that may be the package's, as the layouts of catkin's spaces have it.

    In a devel space the Python package's path begins at a relay and then names the source.
    """
    for entry in importlib.import_module(package).__path__:
        modules = Path(entry).resolve()
        yield modules.parents[1]  # <package>/src/<package>
        yield modules.parents[3] / "share" / package  # <prefix>/lib/python3/dist-packages/<package>

# SPDX-License-Identifier: BSD-3-Clause
"""A part that measures, and an area of them on the page of figures."""

from __future__ import annotations

import importlib
import re
from collections.abc import Callable
from dataclasses import dataclass

from support.figures import Figure
from support.product_code import bench_identity

SYNTHETIC, HUMAN = "synthetic", "human"
MEASURED = "measured"  # figure that says on how much a result rests


@dataclass(frozen=True)
class Part:
    """One command's figures.

    Attributes:
        name: Its name for `make bench ONLY=...`, and with folders for dots that of its file.
        title: Heading on the page.
        place: Module, and its function after a colon; empty: its bench is gone.
        rooms: Of the product, which decide its figures; see support/product_code.py.
        voices: Of all its figures that do not say so themselves.
        details: Regular expressions of figures that the page leaves to the file.
        command: That measures it; empty: `make bench ONLY=<name>`.
        last_in: Last commit with its bench, where that is gone.
        decides: "rest" or "motion", where its figures follow from what hearing decides, and from
            its other rooms: hearing that decides the same on fixed clips leaves them true, but for
            its times.
        moves: "set-points" or "velocities", where its motions are such as those of the fixed
            sessions that are led so: a controller that moves the same in them leaves its figures
            true.
        module: That makes its result, where that is no module of a place.
    """

    name: str
    title: str
    place: str
    rooms: tuple[str, ...]
    voices: str = ""
    details: tuple[str, ...] = ()
    command: str = ""
    last_in: str = ""
    decides: str = ""
    moves: str = ""
    module: str = ""

    @property
    def file(self) -> str:
        """Its result below the folder of results, without the ending."""
        return self.name.replace(".", "/")

    @property
    def bench(self) -> str:
        """Digest of the code that measures it; empty: its bench is gone."""
        module = self.module or (self.place and f"bench.{self.place.partition(':')[0]}")
        return bench_identity(module) if module else ""

    def measure(self) -> list[Figure]:
        """Measure it; imports what that needs, and nothing that other parts need."""
        module, _, function = self.place.partition(":")
        found: Callable[[], list[Figure]] = getattr(
            importlib.import_module(f"bench.{module}"), function or "measure"
        )
        return found()

    def is_shown(self, figure: Figure) -> bool:
        """Whether the page shows one of its figures."""
        return figure.name != MEASURED and not any(re.search(d, figure.name) for d in self.details)


@dataclass(frozen=True)
class Area:
    """Parts that belong together on the page."""

    title: str
    about: str  # what holds for all of them
    parts: tuple[Part, ...]

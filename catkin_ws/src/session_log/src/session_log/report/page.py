# SPDX-License-Identifier: BSD-3-Clause
"""Sets a report as one HTML page that needs nothing outside itself: templates/report.html.

Without its script the page is whole; with it parts fold, utterances sound and the time axis zooms.
"""

from __future__ import annotations

import base64
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cache

import jinja2

from session_log.report.tables.text_table import TextTable
from typed_config import package_folder


@dataclass(frozen=True)
class Image:
    """A figure as PNG, for a wide and for a narrow screen."""

    title: str
    caption: str
    wide: bytes
    narrow: bytes


@dataclass(frozen=True)
class Section:
    """A part of the page under its heading, shown in the order of the fields."""

    title: str
    note: str = ""
    image: Image | None = None
    table: TextTable | None = None
    source: str = ""  # of what the table holds
    details: Mapping[str, Mapping[str, str]] = field(default_factory=dict)  # open on a click
    zoom: Mapping[str, object] = field(default_factory=dict)  # a time axis that zooms: zoom.py
    is_folded: bool = False  # until a click
    search: str = ""  # what its table can be searched for; empty: it cannot


def table_section(title: str, table: TextTable, nothing: str) -> Section:
    """A table, or what is said in its place where it has no row."""
    return Section(title, table=table) if table.rows else Section(title, nothing)


def page(
    title: str,
    subtitle: str,
    warning: str,
    facts: Mapping[str, str],
    sections: Iterable[Section],
) -> str:
    """Set the page.

    Args:
        title: Of the page.
        subtitle: When, how long, of what.
        warning: What is wrong with the recordings; empty for nothing.
        facts: A few figures that are set large, by their names.
        sections: In their order.
    """
    return _template().render(
        title=title, subtitle=subtitle, warning=warning, facts=facts, sections=sections
    )


@cache
def _template() -> jinja2.Template:
    folder = package_folder("session_log") / "templates"
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(folder),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        keep_trailing_newline=True,
    )
    environment.filters["inline"] = _inline
    environment.policies["json.dumps_kwargs"] = {"separators": (",", ":")}
    return environment.get_template("report.html")


def _inline(data: bytes, kind: str = "image/png") -> str:
    return f"data:{kind};base64," + base64.b64encode(data).decode("ascii")

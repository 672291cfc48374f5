# SPDX-License-Identifier: BSD-3-Clause
"""Sets a report as one HTML page that needs nothing outside itself."""

from __future__ import annotations

import base64
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from html import escape

from session_log.report.tables.text_table import NONE, TextTable

STYLE = """
:root { --ink: #1f2933; --quiet: #616e7c; --line: #e4e7eb; --blue: #0072b2; --red: #b3470a; }
* { box-sizing: border-box; }
body { margin: 0; color: var(--ink); background: #fff; line-height: 1.45;
  font: 16px/1.45 system-ui, -apple-system, "Segoe UI", Roboto, "DejaVu Sans", sans-serif; }
main { max-width: 1000px; margin: 0 auto; padding: 24px 20px 60px; }
h1 { font-size: 1.7rem; margin: 0 0 .2rem; }
h2 { font-size: 1.2rem; margin: 2.4rem 0 .6rem; padding-top: .6rem;
  border-top: 1px solid var(--line); }
p { margin: .4rem 0; } .quiet, figcaption { color: var(--quiet); font-size: .9rem; }
a { color: var(--blue); } td.number, th.number { text-align: right; }
.warn { background: #fdf1e7; border-left: 4px solid var(--red); padding: .6rem .8rem; }
.facts { display: grid; grid-template-columns: repeat(auto-fit, minmax(122px, 1fr)); gap: 10px;
  margin: 1.2rem 0; }
.fact { border: 1px solid var(--line); border-radius: 6px; padding: .6rem .8rem; }
.fact b { display: block; font-size: 1.25rem; font-weight: 600; }
figure { margin: 0; } figure img { display: block; width: 100%; height: auto; }
table { border-collapse: collapse; width: 100%; font-size: .86rem; margin: .6rem 0;
  font-variant-numeric: tabular-nums; }
th, td { text-align: left; vertical-align: top; padding: .3rem .6rem .3rem 0;
  border-bottom: 1px solid var(--line); overflow-wrap: break-word; }
th { color: var(--quiet); font-weight: 600; }
tr.bad td { color: var(--red); } tr.warning td { color: #8a5a00; }
tr.nothing td { color: var(--quiet); } tr.total td { font-weight: 600; }
details { margin: .5rem 0; } summary { cursor: pointer; font-weight: 600; }
pre { white-space: pre-wrap; overflow-wrap: anywhere; font-size: .78rem; background: #f5f7fa;
  padding: .6rem; border-radius: 4px; margin: .3rem 0; }
@media (max-width: 640px) {
  main { padding: 16px 14px 40px; }
  .compact { font-size: .8rem; }
  .compact th, .compact td { padding: .3rem .35rem .3rem 0; }
  table:not(.compact) thead { display: none; }
  table:not(.compact) tr { display: block; border-bottom: 1px solid var(--line);
    padding: .45rem 0; }
  table:not(.compact) td { overflow-wrap: anywhere; display: flex; gap: .8rem; border: 0;
    padding: .08rem 0; text-align: left; }
  table:not(.compact) td:first-child { font-weight: 600; }
  table:not(.compact) td.none { display: none; }
  table:not(.compact) td::before { content: attr(data-label); flex: 0 0 9.6rem;
    color: var(--quiet); font-weight: 400; }
}
@media print { h2 { break-after: avoid; } figure, tr { break-inside: avoid; } }
"""


@dataclass(frozen=True)
class Image:
    """A figure as PNG, for a wide and for a narrow screen."""

    title: str
    caption: str
    wide: bytes
    narrow: bytes


def page(title: str, parts: Iterable[str]) -> str:
    """Join the parts of a page."""
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{escape(title)}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n<main>\n"
        + "\n".join(parts)
        + "\n</main>\n</body>\n</html>\n"
    )


def heading(text: str) -> str:
    """Set a section's heading."""
    return f"<h2>{escape(text)}</h2>"


def paragraph(text: str, kind: str = "") -> str:
    """Set a paragraph; `kind` is quiet or warn."""
    return f'<p class="{kind}">{escape(text)}</p>' if kind else f"<p>{escape(text)}</p>"


def title_block(title: str, subtitle: str) -> str:
    """Set the page's title."""
    return f'<h1>{escape(title)}</h1>\n<p class="quiet">{escape(subtitle)}</p>'


def facts(values: Mapping[str, str]) -> str:
    """Set a few figures large."""
    cells = [
        f'<div class="fact"><b>{escape(value)}</b><span class="quiet">{escape(name)}</span></div>'
        for name, value in values.items()
    ]
    return f'<div class="facts">{"".join(cells)}</div>'


def figure(image: Image) -> str:
    """Set a figure with the drawing that fits the screen."""
    return (
        "<figure><picture>"
        f'<source media="(max-width: 640px)" srcset="{_inline(image.narrow)}">'
        f'<img src="{_inline(image.wide)}" alt="{escape(image.title, quote=True)}">'
        f"</picture><figcaption>{escape(image.caption)}</figcaption></figure>"
    )


def table(content: TextTable) -> str:
    """Set a table; on a narrow screen each row becomes a card."""
    head = "".join(
        f"<th{_class('number' if i in content.numbers else '')}>{escape(column)}</th>"
        for i, column in enumerate(content.columns)
    )
    nothing = ("",) * len(content.rows)
    lines = zip(content.rows, content.marks or nothing, content.links or nothing, strict=True)
    body = "".join(
        f'<tr class="{mark}">'
        + "".join(_cell(content, i, row, link) for i in range(len(row)))
        + "</tr>"
        for row, mark, link in lines
    )
    kind = _class("compact" if content.is_compact else "")
    return f"<table{kind}><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


def details(title: str, values: Mapping[str, str]) -> str:
    """Set named texts that open on a click."""
    inner = "".join(f"<p>{escape(k)}</p><pre>{escape(v)}</pre>" for k, v in values.items())
    return f"<details><summary>{escape(title)}</summary>{inner}</details>"


def _cell(content: TextTable, index: int, row: tuple[str, ...], link: str) -> str:
    value, column = row[index], escape(content.columns[index], quote=True)
    kinds = ("none" if value == NONE else "", "number" if index in content.numbers else "")
    kind = _class(" ".join(filter(None, kinds)))
    words = f"<span>{escape(value)}</span>"
    if link and index == 0:
        words = f'<a href="{escape(link, quote=True)}">{words}</a>'
    return f'<td{kind} data-label="{column}">{words}</td>'


def _class(name: str) -> str:
    return f' class="{name}"' if name else ""


def _inline(png: bytes) -> str:
    return "data:image/png;base64," + base64.b64encode(png).decode("ascii")

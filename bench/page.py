# SPDX-License-Identifier: BSD-3-Clause
"""`make figures`: docs/measured.md and the README's figures, made from bench/results."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from bench.catalogue import AREAS, parts
from bench.common.part import HUMAN, MEASURED, SYNTHETIC, Area, Part
from bench.readme_rows import ROWS, ReadmeRow
from support import figures
from support.figures import RESULTS, ROOT, Figure, interval
from support.product_code import beside_hearing, identity

PAGE, FRONT = ROOT / "docs" / "measured.md", ROOT / "README.md"
BEGIN, END = "<!-- figures: by `make figures` -->", "<!-- end of figures -->"
NOTHING = "-"
STOLEN = 0.005  # share of the processors that a host may take without a word
FEW = "met, few trials"  # the bound with 95 % does not reach the target
UNBOUND = "met, no bound"  # a share or a rate that lacks it
SHARES = ("of all", "of commands", "of clips", "of sounds", "of words", "right")  # as older results
UNSAID = re.compile("per hour$|: trusted$|within twice")  # shares and rates of no unit, as those
LARGE, SMALL = 1e4, 1e-3  # from and below which a value is not written with four digits
HEAD = """# Measured

Made by `make figures` from `bench/results`. Do not edit it. Each table names the command that
measures it. Bounds hold with 95 %. Where the trials of each voice are counted apart, the bound is
the wider of the exact one and that of drawing the voices anew. "Met, few trials": the figure
reaches its target, its bound does not. "Met, no bound": it does, but is a share or a rate whose
bound was never computed, as in older results. "None" in the column of targets: reported without
one. Where the code that decides a figure, or its bench, was changed after it was measured, the
table says so. Older results lack some fields: "-".

What is of 28 and 30 November 2026 was measured on machines a quarter to a half slower than others.
"""
SAME, ALIKE, BENCH = "the same decisions", "the same motions", "another bench"
TIMES = ("us", "ms", "s", "% of a core")  # units of what hearing that decides the same may change
TIMED = re.compile(  # figures of the processor's time, whatever their unit; others are simulated
    "real[- ]time|(processor|planning) time|^control tick|^gate: time|^IK .*(time|within)"
)
WHO = {HUMAN: HUMAN, SYNTHETIC: SYNTHETIC, "people:": HUMAN}  # by words in a figure's name
AGES = {
    None: "**Which code was measured is not recorded.**",
    False: "**The code was changed since.**",
    SAME: "Hearing was changed since. On 72 fixed clips, 24 more in motion, it decides the same; "
    "**its times are older.**",
    ALIKE: "The controller was changed since. In nine fixed sessions of 12 s it moves the same; "
    "**its processor times are older.**",
    BENCH: "**The bench was changed since.** The code that it measures does the same.",
    True: "The product's code is as measured.",
}


@dataclass(frozen=True)
class Result:
    """What is on file of a part."""

    part: Part
    machine: dict[str, Any]
    code: str | None  # None: older than the record of it
    decisions: str  # key of what was decided on fixed clips; empty: not recorded
    beside: str  # digest of its code other than that of hearing
    bench: str  # digest of the code that measured it; empty: not recorded
    figures: tuple[Figure, ...]

    @cached_property  # asked for each figure
    def age(self) -> bool | str | None:
        """Which of `AGES` holds."""
        is_of_other_bench = self.bench not in ("", self.part.bench)
        return BENCH if self._age_of_code and is_of_other_bench else self._age_of_code

    @cached_property
    def _age_of_code(self) -> bool | str | None:
        if self.code is None:
            return None
        now = identity(self.part.rooms)
        if self.code == now:
            return True
        if self.part.moves and figures.moves_alike(self.part.moves, self.code, now):
            return ALIKE
        is_same = bool(self.decisions) and self.decisions == figures.decided_now(self.part.decides)
        return SAME if is_same and self.beside == beside_hearing(self.part.rooms) else False

    def age_of(self, figure: Figure) -> bool | str | None:
        """The same for one of its figures."""
        code = self._age_of_code
        is_timed = bool(TIMED.search(figure.name)) or (code == SAME and figure.unit in TIMES)
        return False if is_timed and code in (SAME, ALIKE) else self.age

    def shown(self) -> list[Figure]:
        """Figures for the page."""
        return [figure for figure in self.figures if self.part.is_shown(figure)]

    def voices(self, figure: Figure) -> str:
        """Whose voices a figure is of; older results say it in its name."""
        said = next((who for word, who in WHO.items() if word in figure.name), "")
        return figure.voices or said or self.part.voices


def load(part: Part, folder: Path = RESULTS) -> Result | None:
    """What is on file of a part; None where it was never measured."""
    path = folder / f"{part.file}.json"
    if not path.is_file():
        return None
    data = json.loads(path.read_text(encoding="utf-8"))
    keys = data.get("decisions", ""), data.get("beside_hearing", ""), data.get("bench", "")
    return Result(part, data["machine"], data.get("code"), *keys, tuple(figures.read(path)))


def text(folder: Path = RESULTS) -> str:
    """The page."""
    found = {part.name: load(part, folder) for part in parts()}
    lines = [HEAD, *_missed([result for result in found.values() if result])]
    for area in AREAS:
        lines += [f"\n## {area.title}\n", *([f"{area.about}\n"] if area.about else ())]
        lines += _of_area(area, found)
    return "\n".join(lines).rstrip() + "\n"


def _missed(found: Sequence[Result]) -> Iterator[str]:
    now = [(result, f) for result in found if not result.part.last_in for f in result.shown()]
    verdicts = [figure.is_met for _, figure in now]
    met, missed, none = (verdicts.count(verdict) for verdict in (True, False, None))
    few = met - sum(figure.is_shown for _, figure in now)
    bare = [_is_share(f) for _, f in now if f.is_met and f.bound is None]
    ages = Counter(result.age_of(f) for result, f in now if f.is_met is not None)
    yield f"{met} targets are met and {missed} missed. {none} figures have none.\n"
    yield f"{few} of those met are met by the figure, but not by its bound: too few trials."
    yield f"{sum(bare)} of those met are shares or rates without a bound."
    yield f"{len(bare) - sum(bare)} more are single values, maxima or counts, which have none."
    yield f"Of these verdicts {ages[True]} are of the present code, {ages[SAME] + ages[ALIKE]} of"
    yield "changed code that does the same where that was tried,"
    yield f"{ages[BENCH]} of a bench that was changed since."
    yield f"{ages[False]} of code that was changed since. Of {ages[None]} it is not recorded.\n"
    yield "## Missed\n"
    rows = [
        [_name(f), *_value(f), _target(f), result.voices(f), f"`{result.part.name}`"]
        for result, f in now
        if f.is_met is False
    ]
    yield from _table(["figure", "measured", "95 %", "unit", "target", "voices", "part"], rows)


def _of_area(area: Area, found: Mapping[str, Result | None]) -> Iterator[str]:
    for part in area.parts:
        result = found[part.name]
        if result is None and part.last_in:
            continue
        yield f"### {part.title}\n"
        command = part.command or f"make bench ONLY={part.name}"
        if result is None:
            yield f"`{command}`. Not measured yet.\n"
            continue
        yield f"{' '.join(_circumstances(result, command))}\n"
        rows = [
            [_name(f), *_value(f), _target(f), _verdict(f), result.voices(f), _conditions(f)]
            for f in result.shown()
        ]
        head = ["figure", "measured", "95 %", "unit", "target", "result", "voices", "conditions"]
        yield from _table(head, rows)


def _circumstances(result: Result, command: str) -> Iterator[str]:
    part, where = result.part, result.machine
    yield f"The bench was last in commit {part.last_in}." if part.last_in else f"`{command}`."
    if rests := next((f for f in result.figures if f.name == MEASURED), None):
        whole = f" of {_number(rests.target)}" if rests.is_met is False and rests.target else ""
        yield f"Rests on {_number(rests.value)}{whole} {rests.unit}."
    yield f"{where.get('date', NOTHING)}, commit {where.get('commit', NOTHING)},"
    yield f"{where.get('cpu', NOTHING)}, {where.get('cores', NOTHING)} cores,"
    yield f"load {where.get('load_at_start', NOTHING)} at the start."
    if (stolen := where.get("stolen", 0.0)) >= STOLEN:
        yield f"The host of this virtual machine took {100.0 * stolen:.0f} % of the processors."
    hidden = len([f for f in result.figures if f.name != MEASURED]) - len(result.shown())
    if hidden:
        yield f"{hidden} more figures: [{part.file}.json](../bench/results/{part.file}.json)."
    if not part.last_in:
        yield AGES[result.age]


def readme(folder: Path = RESULTS) -> str:
    """The README's figures, between their marks; few columns, for it is read on phones as well.

    Raises:
        ValueError: A figure is not on file, or is there more than once.
    """
    rows = [_front_row(row, folder) for row in ROWS]
    head = ["figure", "measured", "target", "result"]
    return "\n".join([BEGIN, "", *_table(head, rows), END])


def _front_row(row: ReadmeRow, folder: Path) -> list[str]:
    part = next(part for part in parts() if part.name == row.part)
    result = load(part, folder)
    found = [f for f in (result.figures if result else ()) if f.name == row.figure]
    if result is None or len(found) != 1:
        raise ValueError(f"{row.part}: {len(found)} figures {row.figure!r}, where one is wanted")
    (figure,) = found
    value, _, unit = _value(figure)
    whose = result.voices(figure)
    words = f"{row.words} ({whose})" if whose else row.words
    target = _target(figure).replace("at most", "≤").replace("at least", "≥")
    counts = re.match(r"\d+ of \d+|\d+ in [\d.]+ h|n=\d+", figure.note)
    of = f" ({counts[0]})" if counts else ""
    return [words, f"{float(value.replace(',', '')):.3g} {unit}{of}", target, _verdict(figure)]


# Cells.


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """A table without the columns that would be empty."""
    used = [i for i in range(len(head)) if any(row[i] for row in rows)]
    lines = ["| " + " | ".join(head[i] for i in used) + " |", "|---" * len(used) + "|"]
    cells = ([row[i].replace("|", "/") or NOTHING for i in used] for row in rows)
    return [*lines, *("| " + " | ".join(row) + " |" for row in cells), ""]


def _name(figure: Figure) -> str:
    return figure.name.strip()


def _value(figure: Figure) -> tuple[str, str, str]:
    """Value, bounds and unit."""
    if figure.unit in SHARES:
        return _number(100.0 * figure.value), interval(figure), "%"
    return _number(figure.value), interval(figure), figure.unit


def _target(figure: Figure) -> str:
    if figure.target is None:
        return "none"
    value = figure.target * (100.0 if figure.unit in SHARES else 1.0)
    return f"{'at most' if figure.at_most else 'at least'} {_number(value)}"


def _verdict(figure: Figure) -> str:
    if figure.is_met and not figure.is_shown:
        return FEW
    if figure.is_met and figure.bound is None and _is_share(figure):
        return UNBOUND
    return {True: "met", False: "**missed**", None: ""}[figure.is_met]


def _is_share(figure: Figure) -> bool:
    """Whether it is a share of trials or a rate, which a bound belongs to; a maximum is none."""
    has_unit = figure.unit in (*SHARES, "%", "per h") and not figure.name.endswith("max")
    return has_unit or bool(UNSAID.search(figure.name))


def _conditions(figure: Figure) -> str:
    note = " ".join(figure.note.split())
    return note[1:-1] if note.startswith("(") and note.endswith(")") else note


def _number(value: float) -> str:
    if value == round(value) or abs(value) >= LARGE:
        return f"{value:,.0f}"
    return f"{value:.1e}" if abs(value) < SMALL else f"{value:.4g}"


# Files.


def in_readme(page: str) -> str:
    """The README with its figures as they are on file.

    Raises:
        ValueError: It has no marks.
    """
    before, begin, rest = page.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not begin or not end:
        raise ValueError(f"{FRONT.name}: no lines {BEGIN} and {END}")
    return before + readme() + after


def write() -> None:
    """Write the page and the README's figures."""
    PAGE.write_text(text(), encoding="utf-8")
    FRONT.write_text(in_readme(FRONT.read_text(encoding="utf-8")), encoding="utf-8")
    print(f"written: {PAGE.relative_to(ROOT)} and the figures of {FRONT.name}")


if __name__ == "__main__":
    write()

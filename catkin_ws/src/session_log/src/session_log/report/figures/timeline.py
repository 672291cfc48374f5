# SPDX-License-Identifier: BSD-3-Clause
"""Timeline: what was said, what was decided, what the robot did."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import cycle

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from session_log.report.figures.figure import SessionFigure, SessionMaterial
from session_log.report.figures.style import (
    GREEN,
    INK,
    MODE_COLORS,
    PHASE_COLORS,
    PURPLE,
    QUIET,
    RED,
    SKY,
    SOUND,
    STATE_COLORS,
    Layout,
    new_figure,
    thin,
    with_gaps,
)
from session_log.report.session.analysis import FAILED
from session_log.report.session.session_data import Span
from session_log.report.session.trials import NOT_SAID, NOTHING, PhraseTrial

WRONG = ("refused", FAILED)  # outcomes
MOST_ROWS = 6
LANES = 4
LONGEST_LABEL = 26  # characters
LETTER = 0.058  # [in] width of a letter of a label
QUIETEST, LOUDEST = -70.0, 0.0  # [dBFS]

MARKS = {  # by kind of event: shape, colour, words
    "refused": ("X", RED, "refused"),
    "stop_received": ("s", INK, "stop received"),
    "trocar_set": ("P", PURPLE, "trocar set"),
    "trocar_refused": ("v", PURPLE, "trocar refused"),
    "grasp_set": ("P", PURPLE, "grasp point set"),
    "grasp_refused": ("v", PURPLE, "grasp point refused"),
}

SETTINGS = ("trocar_set", "trocar_refused", "grasp_set", "grasp_refused")  # events of a set-up


@dataclass(frozen=True)
class TimelineRow:
    """The stretch of time that one row of the timeline shows."""

    start: float  # [s]
    end: float  # [s]
    letter: float  # [s] width of a letter of a label

    @property
    def length(self) -> float:
        """Length of the row [s]."""
        return self.end - self.start


@dataclass(frozen=True)
class TimelineLabel:
    """What stands above the moment of a decision."""

    time: float  # [s]
    words: str
    color: str
    style: str  # normal or italic


class TimelineFigure(SessionFigure):
    """Speech, decisions, voice mode, robot state and phase."""

    name = "timeline"
    title = "Timeline"
    lacking = "The recording holds no utterances, events or controller states."

    def can_draw(self, material: SessionMaterial) -> bool:
        """Whether anything happened."""
        data = material.data
        return bool(data.heard or data.events or data.states)

    def caption(self, material: SessionMaterial) -> str:
        """Count what happened."""
        heard = material.data.heard
        matched = sum(1 for h in heard if h.command)
        refused = sum(1 for row in material.rows if row.heard and row.outcome == "refused")
        failed = sum(1 for row in material.rows if row.outcome == FAILED)
        return (
            f"{len(heard)} utterances, {matched} taken for a command, {len(heard) - matched} not; "
            f"of the commands, the controller refused {refused}. "
            + (f"Device calls that failed: {failed}. " if failed else "")
            + "Bars: speech; labels stand at the decision. Grey: sound level."
            + _setting_words(material)
        )

    def draw(self, material: SessionMaterial, layout: Layout) -> Figure:
        """Draw the session in rows of equal length."""
        rows = _rows(material.duration, layout)
        figure = new_figure(layout, 0.55 + 1.75 * len(rows))
        heights = [1.0, 0.62] * len(rows)
        axes = figure.subplots(2 * len(rows), 1, height_ratios=heights, squeeze=False)[:, 0]
        for index, row in enumerate(rows):
            speech, bands = axes[2 * index], axes[2 * index + 1]
            _draw_speech(speech, material, row)
            _draw_bands(bands, material, row)
            for ax in (speech, bands):
                ax.set_xlim(row.start, row.end)
        axes[-1].set_xlabel("time since the session began [s]")
        columns = 5 if layout.is_wide else 3
        figure.legend(handles=_legend(material), loc="outside lower center", ncols=columns)
        return figure


def _setting_words(material: SessionMaterial) -> str:
    return "".join(
        f" {MARKS[e.kind][2].capitalize()} at {e.time:.1f} s"
        + (f" ({e.message})." if e.message else ".")
        for e in material.data.events
        if e.kind in SETTINGS
    )


def _rows(duration: float, layout: Layout) -> list[TimelineRow]:
    count = min(max(math.ceil(duration / layout.seconds_per_row), 1), MOST_ROWS)
    length = max(duration, 1.0) / count
    letter = LETTER * length / (layout.width - 0.8)
    return [TimelineRow(i * length, (i + 1) * length, letter) for i in range(count)]


def _draw_speech(ax: Axes, material: SessionMaterial, row: TimelineRow) -> None:
    sound = material.data.sound
    mine = (sound["time"] >= row.start) & (sound["time"] <= row.end)
    ax.set_ylim(-0.5, 1.0 + 0.8 * LANES)
    ax.set_yticks([0.15], ["speech"])
    ax.tick_params(axis="x", labelbottom=False, length=0)
    ax.tick_params(axis="y", length=0)
    ax.spines[["left", "bottom"]].set_visible(False)
    if mine.any():
        level = (sound["level"].clip(QUIETEST, LOUDEST) - QUIETEST) / (LOUDEST - QUIETEST)
        time, level = thin(*with_gaps(sound["time"][mine], level[mine]))
        ax.fill_between(time, -0.1, -0.1 + 0.8 * level, color=SOUND, lw=0)
    labels = [label for label in timeline_labels(material) if row.start <= label.time < row.end]
    for color, is_command in ((GREEN, True), (QUIET, False)):
        speech = [
            Span(h.speech_start, max(h.speech_end, h.speech_start + 0.05), "")
            for h in material.data.heard
            if bool(h.command) == is_command
        ]
        _draw_bars(ax, (-0.45, 0.3), speech, color, row)
    if sum(len(label.words) * row.letter for label in labels) > 0.9 * LANES * row.length:
        wrong = [label for label in labels if label.color in (RED, PURPLE)]
        others = [label.time for label in labels if label not in wrong]
        _draw_labels(ax, wrong, others, row)
    else:
        _draw_labels(ax, labels, [], row)


def _draw_labels(
    ax: Axes, labels: list[TimelineLabel], left_out: list[float], row: TimelineRow
) -> None:
    """Write the labels that find room, and mark the moments of the others, `left_out` too [s]."""
    free = [row.start] * LANES
    for label in labels:
        width = (len(label.words) + 2) * row.letter
        left = min(label.time, row.end - width)
        lane = next((i for i in range(LANES) if free[i] <= left), None)
        if lane is None:
            left_out.append(label.time)
            continue
        free[lane] = left + width
        _draw_label(ax, label, left + 0.5 * row.letter, 1.0 + 0.8 * lane)
    if left_out:
        top = 1.0 + 0.8 * LANES
        ax.plot(left_out, [top] * len(left_out), ls="", marker="v", ms=2.5, color=QUIET)
        words = f"{len(left_out)} without room for a label"
        ax.text(row.end, top, words, ha="right", va="bottom", fontsize=6, color=QUIET)


def _draw_label(ax: Axes, label: TimelineLabel, left: float, y: float) -> None:
    ax.plot([label.time] * 2, [-0.45, y + 0.5], color=label.color, lw=0.5, zorder=1)
    ax.text(
        left,
        y,
        label.words,
        fontsize=7,
        color=label.color,
        style=label.style,
        parse_math=False,  # what was heard may hold dollar signs
        bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.6},
        zorder=2,
    )


def timeline_labels(material: SessionMaterial) -> list[TimelineLabel]:
    """Every command, every utterance that was none, every phrase taken wrongly; by time."""
    labels = [
        TimelineLabel(row.time, row.command, RED if row.outcome in WRONG else INK, "normal")
        for row in material.rows
    ]
    wrong = (trial for trial in material.trials if not trial.is_correct)
    labels += [TimelineLabel(t.time, _misheard(t), PURPLE, "normal") for t in wrong]
    silent = (heard for heard in material.data.heard if not heard.command)
    labels += [TimelineLabel(h.decision, _quoted(h.transcript), QUIET, "italic") for h in silent]
    return sorted(labels, key=lambda label: label.time)


def _misheard(trial: PhraseTrial) -> str:
    meant = trial.intended if trial.intended == NOT_SAID else f"meant: {trial.intended}"
    return f"{meant} ({trial.taken})" if trial.taken == NOTHING else meant


def _quoted(words: str) -> str:
    return f"“{words}”" if len(words) <= LONGEST_LABEL else f"“{words[: LONGEST_LABEL - 1]}…”"


def _draw_bands(ax: Axes, material: SessionMaterial, row: TimelineRow) -> None:
    data = material.data
    _draw_band(ax, 2.0, data.modes, MODE_COLORS, row)
    _draw_band(ax, 1.0, data.states, STATE_COLORS, row)
    _draw_band(ax, 0.0, data.phases, _phase_colors(data.phases), row)
    for span in data.phases:
        wide_enough = span.end - span.start > (len(span.word) + 0.5) * 0.75 * row.letter
        if span.word and wide_enough and row.start <= span.start and span.end <= row.end:
            middle = (span.start + span.end) / 2
            ax.text(
                middle, 0.0, span.word, ha="center", va="center", fontsize=6.5, parse_math=False
            )
    for kind, (shape, color, _) in MARKS.items():
        times = [e.time for e in data.events if e.kind == kind and row.start <= e.time < row.end]
        ones = [1.0] * len(times)
        ax.plot(times, ones, ls="", marker=shape, color=color, ms=6, mec="white", mew=0.6)
    ax.set_ylim(-0.5, 2.5)
    ax.set_yticks([2.0, 1.0, 0.0], ["voice", "robot", "phase"])
    ax.tick_params(axis="y", length=0)
    ax.spines["left"].set_visible(False)


def _draw_band(
    ax: Axes, y: float, spans: list[Span], colors: dict[str, str], row: TimelineRow
) -> None:
    for word, color in colors.items():
        _draw_bars(ax, (y - 0.36, 0.72), [s for s in spans if s.word == word], color, row)


def _draw_bars(
    ax: Axes, place: tuple[float, float], spans: list[Span], color: str, row: TimelineRow
) -> None:
    """Bars of one colour, as one artist; `place` is where they begin and how high they are."""
    shown = [(s.start, s.end - s.start) for s in spans if s.end > row.start and s.start < row.end]
    if shown:
        ax.broken_barh(shown, place, color=color, lw=0)


def _phase_colors(phases: list[Span]) -> dict[str, str]:
    words = dict.fromkeys(span.word for span in phases if span.word)
    return dict(zip(words, cycle(PHASE_COLORS)))


def _legend(material: SessionMaterial) -> list[Patch | Line2D]:
    data = material.data
    shown = {span.word for span in data.states}
    handles: list[Patch | Line2D] = []
    if any(h.command for h in data.heard):
        handles.append(Patch(color=GREEN, label="command"))
    if any(not h.command for h in data.heard):
        handles.append(Patch(color=QUIET, label="no command"))
    if data.modes:
        handles.append(Patch(color=SKY, label="voice active"))
    handles += [
        Patch(color=color, label=state) for state, color in STATE_COLORS.items() if state in shown
    ]
    kinds = {event.kind for event in data.events}
    return handles + [_marker(*mark) for kind, mark in MARKS.items() if kind in kinds]


def _marker(marker: str, color: str, label: str) -> Line2D:
    return Line2D([], [], ls="", marker=marker, color=color, mec="white", ms=6, label=label)

# SPDX-License-Identifier: BSD-3-Clause
"""What the page's timeline that zooms is drawn from: templates/report.js draws it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from session_log.report.figures import SessionMaterial, style
from session_log.report.figures.timeline import LOUDEST, QUIETEST, timeline_labels
from session_log.report.notes import Note
from session_log.report.session.session_data import Span, Track
from session_log.report.session.tension import measured_tension

POINTS = 8000  # of a curve

Drawn = dict[str, object]


def zoom_data(material: SessionMaterial, notes: Iterable[Note]) -> Drawn:
    """Everything on the time axis, in values for JSON.

    Args:
        material: Of the session.
        notes: On it; those of a moment are marked.
    """
    data = material.data
    tension = measured_tension(data, material.config.topics.tension)
    speech = [
        (u.speech_start, u.speech_end, "", style.GREEN if u.command else style.QUIET)
        for u in data.heard
    ]
    marks = [(label.time, label.words, label.color) for label in timeline_labels(material)]
    marks += [(note.time, note.words, style.INK) for note in notes if note.time is not None]
    return {
        "duration": round(max(material.duration, 1.0), 3),
        "marks": [(round(t, 2), words, color) for t, words, color in sorted(marks)],
        "speech": _rounded(speech),
        "bands": [
            {"name": "voice", "spans": _colored(data.modes, style.MODE_COLORS)},
            {"name": "robot", "spans": _colored(data.states, style.STATE_COLORS)},
            {"name": "phase", "spans": _colored([s for s in data.phases if s.word], {})},
        ],
        "curves": [
            _curve("sound [dBFS]", data.sound["time"], data.sound["level"].clip(QUIETEST, LOUDEST)),
            _curve("tension [N]", tension["time"], tension["tension"]),
        ],
    }


def _colored(spans: Iterable[Span], colors: dict[str, str]) -> list[Sequence[object]]:
    usual = style.PHASE_COLORS[0]
    return _rounded([(s.start, s.end, s.word, colors.get(s.word, usual)) for s in spans])


def _rounded(spans: Iterable[tuple[float, float, str, str]]) -> list[Sequence[object]]:
    return [(round(start, 2), round(end, 2), *rest) for start, end, *rest in spans]


def _curve(name: str, time: Track, value: Track) -> Drawn:
    """A curve with gaps where its value is no number, which JSON has no word for."""
    if not np.isfinite(value).any():
        return {"name": name, "time": [], "value": []}
    time, value = style.thin(*style.with_gaps(time, value), POINTS)
    known = [v if math.isfinite(v) else None for v in value.round(2).tolist()]
    return {"name": name, "time": time.round(2).tolist(), "value": known}

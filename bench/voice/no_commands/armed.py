# SPDX-License-Identifier: BSD-3-Clause
"""False commands, armed, in all human speech that is kept for measuring."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

import soundfile

from bench.common import resumable
from bench.voice import outcomes
from bench.voice.hearing import pieces
from bench.voice.hearing.pieces import SceneRecord
from bench.voice.material.mixing import chunks, trials_of
from bench.voice.material.synthesis import DEV, TALK, SpokenClip, recorded
from bench.voice.outcomes import hours, motions
from bench.voice.trials import STOP
from support.figures import ROOT, Figure, rate

WORDS, WAKE_WORDS, SENTENCES = "single words", "other devices' words", "talk without transcript"


def measure() -> list[Figure]:
    """Motions, of which there shall be none, and stops per hour; by kind of clip."""
    records = measured()
    figures = by_kind("armed", records, 0.5)
    if figures:
        data = {"fired": fired(records), "clips": Counter(_kinds().values())}
        resumable.write_details("voice/armed_fired.json", hours(records), data)
    return figures


def by_kind(state: str, records: Sequence[SceneRecord], stops: float) -> list[Figure]:
    """False commands in all clips, and in each kind of them; none where there are no recordings.

    Args:
        state: In which they are heard.
        records: Of all clips.
        stops: Most false stops [1/h].
    """
    kinds = _kinds()
    if not kinds:
        print("no human speech in ../shared/speech: false commands left out")
        return []
    figures = [resumable.measured(round(hours(records), 3), "h", round(length(clips()), 3))]
    figures += of_commands(f"human speech, {state}", records, 0.0, stops)
    for kind in (SENTENCES, WORDS, WAKE_WORDS):
        some = [r for r in records if kinds[r.label["path"]] == kind]
        if some:
            figures += of_commands(f"{kind}, {state}", some)
    return figures


def measured() -> list[SceneRecord]:
    """All clips in which nobody says "stop", armed; none where there are no recordings."""
    return pieces.measured("armed", {"": chunks(trials_of(clips()))})[""]


def of_commands(
    name: str,
    records: Sequence[SceneRecord],
    motion: float | None = None,
    stop: float | None = None,
    unique: float | None = None,
) -> list[Figure]:
    """Commands taken where none was said.

    Args:
        name: Of the set.
        records: Its scenes, each with its length in its label.
        motion: Most motions; None: no target.
        stop: Most stops [1/h]; None: no target.
        unique: Of recordings that are heard again and again, their length [h].
    """
    heard = hours(records)
    taken = Counter(command for r in records for command in r.heard.taken)
    moved = sum(taken[command] for command in motions())
    which = ", ".join(f"{command}: {taken[command]}" for command in sorted(motions() & set(taken)))
    is_again = unique is not None and unique < heard
    again = f"{unique:.2f} h of clips, heard again and again" if is_again else ""
    which = "; ".join(filter(None, (which, again)))
    counted = (
        ("false motions", moved, motion, which),
        ("false stops", taken["stop"], stop, again),
        ("hey robot taken", taken["hey robot"], None, again),
        ("terminate taken", taken["terminate"], None, again),
    )
    return [
        rate(f"{name}: {what}", count, heard, most, note, unique=unique)
        for what, count, most, note in counted
    ]


def fired(records: Sequence[SceneRecord]) -> list[dict[str, Any]]:
    """Every command taken where none was said, with what was said and by whom."""
    return outcomes.fired(records, "text", "engine", "voice", "path")


def clips() -> list[SpokenClip]:
    """All of them."""
    return [clip for clip in recorded(TALK, DEV) if clip.text not in STOP]


def _kinds() -> dict[str, str]:
    """By path: words of `dev`, talk that nobody wrote down, or what wakes other devices."""
    words = {clip.path for clip in recorded(DEV)}
    return {
        clip.path: WORDS if clip.path in words else WAKE_WORDS if clip.text else SENTENCES
        for clip in clips()
    }


def length(clips: Sequence[SpokenClip]) -> float:
    """Of all clips [h]."""
    return sum(soundfile.info(ROOT / clip.path).duration for clip in clips) / 3600.0

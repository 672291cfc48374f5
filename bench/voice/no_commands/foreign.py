# SPDX-License-Identifier: BSD-3-Clause
"""Words and short talk of nine languages, armed, of which none may move anything.

Beside them English commands in voices that training never used and in voices that it used: what a
rule against foreign words costs stands beside what it gives.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

from bench.voice.hearing import pieces
from bench.voice.hearing.pieces import SceneRecord
from bench.voice.material.foreign_clips import (
    by_espeak,
    by_kokoro,
    commands_by_kokoro,
    language_of,
)
from bench.voice.material.held_out_voices import SyntheticVoice, foreigners, natives, spread
from bench.voice.material.mixing import PER_CHUNK, StreamedTrial, trials_of
from bench.voice.material.synthesis import SpokenClip, spoken
from bench.voice.outcomes import motions, others, right, share_of_voices, tally, voice
from bench.voice.trials import MOTIONS, STOP
from support.figures import Figure
from voice_assist.training.data.voices import ACCENTS, FLITE, RHVOICE, espeak_variants

SEED = 19
EACH = 2  # times that each held-out native voice says each command
COMMANDS = (*MOTIONS, *STOP)
STRANGE = "it sounds like another word"  # how the reason of the verifier begins
FOREIGN = ("near words", "words", "talk", "named", "MBROLA", "Kokoro")
ENGLISH = (
    *("held-out voices", "accents", "trained voices"),
    *("Kokoro's natives", "Kokoro's accents"),
)


def measure() -> list[Figure]:
    """Share of foreign words taken for a command, and of English commands that are right."""
    found, count = pieces.found("foreign", plan(), PER_CHUNK)
    figures = [count]
    words = [r for name in FOREIGN if name != "named" for r in found.get(name, ())]
    figures.append(_moved("words and talk of nine languages", words, 0.0))
    figures += [_moved(name, found[name], 0.0) for name in FOREIGN if name in found]
    languages: dict[str, list[SceneRecord]] = {}
    for record in words:
        name = language_of(record.label["engine"], record.label["voice"])
        languages.setdefault(name, []).append(record)
    figures += [_moved(name, records) for name, records in languages.items()]
    stops = [r for r in words if "stop" in r.heard.taken]
    figures.append(Figure("words and talk: taken as stop", len(stops), "", note=_said(stops)))
    for name in ENGLISH:
        if name in found:
            figures += _commands(name, found[name])
    return figures


@cache
def plan() -> dict[str, list[StreamedTrial]]:
    """Trials by their set."""
    trained, _ = espeak_variants()
    cast = [SyntheticVoice("espeak", f"{ACCENTS[i % 7]}+{v}") for i, v in enumerate(trained[::3])]
    cast += [SyntheticVoice("flite", name) for name in FLITE]
    cast += [SyntheticVoice("rhvoice", name) for name in RHVOICE]
    sets: dict[str, Sequence[SpokenClip]] = {
        **by_espeak(),
        "Kokoro": by_kokoro(),
        "held-out voices": spoken(spread(COMMANDS, natives().present, EACH, SEED)),
        "accents": spoken(spread(COMMANDS, foreigners().present, 2, SEED)),
        "trained voices": spoken(spread(COMMANDS, sorted(cast), 1, SEED)),
        **commands_by_kokoro(COMMANDS),
    }
    return {name: trials_of(clips) for name, clips in sets.items() if clips}


def _commands(name: str, records: Sequence[SceneRecord]) -> list[Figure]:
    moving = [r for r in records if r.label["text"] in MOTIONS]
    stops = [r for r in records if r.label["text"] in STOP]
    lost = [r for r in moving if r.label["text"] in _refused(r)]
    note = f"(of {len(moving)}, {sum(r.label['text'] == 'release' for r in lost)} of them release)"
    figures = [right(f"English motion commands, {name}", tally(moving))]
    figures.append(Figure(f"{name}: refused by the verifier", len(lost), "", note=note))
    for command in MOTIONS:
        some = [r for r in moving if r.label["text"] == command]
        figures.append(right(f"{command}, {name}", tally(some)))
    figures.append(right(f"stop, {name}", tally(stops)))
    return [*figures, *others(f"English commands, {name}", tally(records))]


def _moved(name: str, records: Sequence[SceneRecord], target: float | None = None) -> Figure:
    """Share of some scenes in which a motion was taken."""
    trials = [(voice(r), not motions().isdisjoint(r.heard.taken)) for r in records]
    moved = [r for r, (_, is_moved) in zip(records, trials, strict=True) if is_moved]
    without = [r for r in records if not motions().isdisjoint((*r.heard.taken, *_refused(r)))]
    note = f"without the verifier {len(without)}{_said(moved) and ': ' + _said(moved)}"
    return share_of_voices(f"{name}: taken as motion", trials, target, at_most=True, note=note)


def _refused(record: SceneRecord) -> set[str]:
    """Commands that the verifier alone refused: it is asked after all but the rejection rules."""
    return {s.command for s in record.heard.said if not s.is_taken and s.why.startswith(STRANGE)}


def _said(records: Sequence[SceneRecord]) -> str:
    said = {f"{r.label['voice'].partition('+')[0]} {r.label['text']}" for r in records}
    return ", ".join(sorted(said))

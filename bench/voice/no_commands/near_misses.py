# SPDX-License-Identifier: BSD-3-Clause
"""Near misses, denied commands and commands inside sentences, in held-out voices.

"pull moor" is "pull more" in some accents. A phrase whose sounds are those of a command in the
speaker's own voice cannot be distinguished from it. Such phrases are counted apart.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from bench.common import resumable
from bench.voice import outcomes
from bench.voice.hearing import pieces
from bench.voice.hearing.pieces import SceneRecord
from bench.voice.material.clips import SEED as HELD_OUT_SEED
from bench.voice.material.confusable_phrases import ALL, NAMED, TRAINED, plan
from bench.voice.material.held_out_voices import natives, spread
from bench.voice.material.mixing import StreamedTrial, chunks, trials_of
from bench.voice.material.synthesis import spoken
from bench.voice.outcomes import in_percent, motions, share_of_voices, voice
from bench.voice.trials import THIN, WHOLE
from support.figures import Figure
from voice_assist.training.data.homophones import same_as_command

FULL = 12  # voices per phrase at THIN=1
SEED = 7
PHRASES, OWN = "phrases", "named"


def measure() -> list[Figure]:
    """Share of them taken as a motion; stops apart, since they are safe."""
    found = measured()
    done = sum(map(len, found.values()))
    full = sum(map(len, _trials(min(THIN, WHOLE)).values()))
    resumable.write_details("voice/near_taken.json", done, {k: taken(r) for k, r in found.items()})
    return [
        resumable.measured(done, "trials", full),
        *figures(found[PHRASES]),
        *of_named(found[OWN]),
    ]


def figures(records: Sequence[SceneRecord]) -> list[Figure]:
    """What was taken of phrases that are no command."""
    moved = motions()
    distinct, same = _apart(records)
    found = [
        _share("near misses: taken as motion", distinct, moved, 0.005),
        _share("near misses, those that sound the same too: taken as motion", records, moved),
    ]
    if same:
        found.append(_share("same sounds as a command: taken as motion", same, moved))
    new = [r for r in distinct if r.label["text"] not in TRAINED]
    found.append(_share("near misses, words never trained on: taken as motion", new, moved))
    for name, phrases in ALL.items():
        some = [r for r in distinct if r.label["text"] in phrases]
        target = 0.0 if name == "denied" else None
        found.append(_share(f"{name}: taken as motion", some, moved, target))
        found.append(_share(f"{name}: taken as stop", some, {"stop"}))
    found.append(_share("near misses: taken as hey robot", distinct, {"hey robot"}))
    found.append(_share("near misses: taken as terminate", distinct, {"terminate"}))
    return [f for f in found if f.unit]


def of_named(records: Sequence[SceneRecord]) -> list[Figure]:
    """The list of the requirement, each phrase in every held-out voice."""
    distinct, same = _apart(records)
    name = "tents, dense, least ... terminal in every voice"
    found = [
        _share(f"{name}: taken as motion", distinct, motions(), 0.005),
        _share(f"{name}: taken as stop", distinct, {"stop"}),
    ]
    if same:
        title = f"{name}, same sounds as a command: taken as motion"
        found.append(_share(title, same, motions()))
    return [f for f in found if f.unit]


def is_same(record: SceneRecord) -> bool:
    """Whether it has the sounds of a command in the voice that says it."""
    label = record.label
    return same_as_command(label["text"], label["engine"], label["voice"])


def taken(records: Iterable[SceneRecord]) -> list[dict[str, Any]]:
    """Every phrase that was taken for a command, motions first."""
    found = [
        {
            **one,
            "said": r.label["text"],
            "voice": voice(r),
            "is_motion": one["taken"] in motions(),
            "same_sounds": is_same(r),
        }
        for r in records
        for one in outcomes.fired([r], "path")
    ]
    return sorted(found, key=lambda one: (not one["is_motion"], one["said"]))


def measured() -> dict[str, list[SceneRecord]]:
    """Phrases and the requirement's own list through the pipeline, armed."""
    plans = {name: chunks(trials) for name, trials in _trials(THIN).items()}
    return pieces.measured("near", plans)


def _trials(thin: int) -> dict[str, list[StreamedTrial]]:
    prompts = plan(HELD_OUT_SEED, max(1, FULL // (2 * thin)))
    own = spread(NAMED, natives().present, 1, SEED)
    return {PHRASES: trials_of(spoken(prompts)), OWN: trials_of(spoken(own))}


def _apart(records: Sequence[SceneRecord]) -> tuple[list[SceneRecord], list[SceneRecord]]:
    """Those that differ from a command, and those that sound the same."""
    distinct = [r for r in records if not is_same(r)]
    return distinct, [r for r in records if is_same(r)]


def _share(
    name: str, records: Sequence[SceneRecord], commands: Iterable[str], target: float | None = None
) -> Figure:
    """A figure without a unit where there are no records."""
    if not records:
        return Figure(name, 0.0, "")
    trials = [(voice(r), not set(commands).isdisjoint(r.heard.taken)) for r in records]
    wrong = (r for r, (_, is_taken) in zip(records, trials, strict=True) if is_taken)
    said = ", ".join(sorted({f"{r.label['text']!r}" for r in wrong}))
    return share_of_voices(name, trials, in_percent(target), at_most=True, note=said)

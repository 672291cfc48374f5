# SPDX-License-Identifier: BSD-3-Clause
"""Thousands of commands in voices that training never used, in quiet and in theatre noise.

Every voice says every command of a group equally often. THIN=3: in noise one trial in three, which
is the whole plan; more is a part of it.
"""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from typing import Any

from bench.common import resumable
from bench.voice import outcomes
from bench.voice.hearing import pieces
from bench.voice.hearing.pieces import SceneRecord
from bench.voice.material.held_out_voices import SyntheticVoice, foreigners, natives, spread
from bench.voice.material.mixing import StreamedTrial, chunks, trials_of
from bench.voice.material.synthesis import SpokenClip, spoken
from bench.voice.outcomes import by, latencies, others, quantiles, right, tally
from support.figures import Figure

THIN = int(os.environ.get("THIN", "3"))  # one trial in so many in noise
SEED = 5
MOTIONS = ("tense", "release", "pull more", "pull less")
STOP, OTHERS = ("stop",), ("hey robot", "terminate")
MIN_TRIALS = {MOTIONS: 3000, STOP: 1000, OTHERS: 500}  # trials of each group
WHOLE = 3  # THIN from which on the plan counts as whole
FOREIGN_EACH = 4  # times that each foreign voice says each command
SNRS = (10, 6, 0)  # [dB]
TARGETS = {  # least share right; the condition's name, the group
    ("quiet", MOTIONS): 0.995,
    ("6 dB", MOTIONS): 0.98,
    ("0 dB", MOTIONS): 0.90,
    ("quiet", STOP): 0.995,
    ("10 dB", STOP): 0.99,
    ("0 dB", STOP): 0.97,
}
NAMES = {MOTIONS: "motion commands", STOP: "stop", OTHERS: "hey robot and terminate"}


def measure() -> list[Figure]:
    """Right, nothing, another command and the opposite; by engine, by command, by noise."""
    plans = {name: chunks(trials) for name, trials in conditions(THIN).items() if trials}
    every = pieces.measured("trials", plans)
    found = {name: records for name, records in every.items() if records}
    done = sum(map(len, found.values()))
    figures = [resumable.measured(done, "trials", full())]
    for condition, records in found.items():
        figures += _of_condition(condition, records)
    figures += _latency(found.get("quiet", ()))
    missing = (*natives().missing, *foreigners().missing)
    names = ", ".join(map(str, missing))
    figures.append(Figure("voices missing here", len(missing), "", note=f"({names or 'none'})"))
    resumable.write_details(
        "voice/trials_table.json", done, {k: _table(r) for k, r in found.items()}
    )
    missed = {name: outcomes.misses(records) for name, records in found.items()}
    resumable.write_details("voice/trials_missed.json", done, missed)
    return figures


@cache
def clips_of(commands: tuple[str, ...]) -> tuple[SpokenClip, ...]:
    """A group of commands in all held-out native voices.

    Args:
        commands: A key of MIN_TRIALS.
    """
    cast = natives().present
    each = math.ceil(MIN_TRIALS[commands] / (len(commands) * len(cast)))
    return tuple(spoken(spread(commands, cast, each, SEED)))


@cache
def foreign() -> tuple[SpokenClip, ...]:
    """All commands in the voices of other languages."""
    cast: Sequence[SyntheticVoice] = foreigners().present
    commands = (*MOTIONS, *STOP, *OTHERS)
    return tuple(spoken(spread(commands, cast, FOREIGN_EACH, SEED))) if cast else ()


def conditions(thin: int) -> dict[str, list[StreamedTrial]]:
    """Trials by their condition.

    Args:
        thin: In noise one trial in so many.
    """
    quiet = [trial for group in MIN_TRIALS for trial in trials_of(clips_of(group))]
    found = {"quiet": quiet}
    for snr in SNRS:
        some = quiet[::thin]
        found[f"{snr} dB"] = [replace(t, background="theatre", snr=float(snr)) for t in some]
    found["foreign accents"] = trials_of(foreign())
    return found


def full() -> int:
    """Trials of the whole plan."""
    return sum(map(len, conditions(min(THIN, WHOLE)).values()))


def _of_condition(condition: str, records: Sequence[SceneRecord]) -> list[Figure]:
    figures = []
    for group, name in NAMES.items():
        some = [r for r in records if r.label["text"] in group]
        if not some:
            continue
        count, title = tally(some), f"{name}, {condition}"
        figures.append(right(title, count, TARGETS.get((condition, group))))
        if group == MOTIONS and condition == "quiet":
            figures.append(_mean_of_engines(f"{title}: right, mean of the engines", some))
        for command in group if len(group) > 1 else ():
            said = [r for r in some if r.label["text"] == command]
            if said:
                figures.append(right(f"{command}, {condition}", tally(said)))
    figures += others(f"all commands, {condition}", tally(records), condition == "quiet")
    if condition == "quiet":
        groups = by(records, outcomes.engine)
        figures += [right(f"{engine}, {condition}", count) for engine, count in groups.items()]
    return figures


def _mean_of_engines(name: str, records: Sequence[SceneRecord]) -> Figure:
    """Each engine counts the same, for two of three voices are espeak-ng's."""
    counts = by(records, outcomes.engine)
    each = "; ".join(f"{engine} {count.right} of {count.n}" for engine, count in counts.items())
    mean = 100.0 * sum(count.right / count.n for count in counts.values()) / len(counts)
    return Figure(name, mean, "%", note=f"({each})")


def _latency(records: Sequence[SceneRecord]) -> list[Figure]:
    """Of all commands but "stop", whose are in `voice.stop`."""
    figures = []
    for command, times in latencies(records).items():
        if command in STOP:
            continue
        limits = {"p50": 200.0, "p95": 500.0}
        for name, value in quantiles(times).items():
            note = f"({len(times)} trials; stream time and CPU time)" if name == "p50" else ""
            figures.append(Figure(f"{command}: {name}", value, "ms", limits.get(name), note=note))
    return figures


def _table(records: Sequence[SceneRecord]) -> dict[str, Any]:
    """Counts with bounds by engine, by command, and of both, and by voice."""
    keys = {
        "by_engine": outcomes.engine,
        "by_command": outcomes.text,
        "by_voice": outcomes.voice,
        "by_engine_and_command": lambda r: f"{outcomes.engine(r)}, {outcomes.text(r)}",
    }
    tables = {
        name: {group: count.to_json() for group, count in by(records, key).items()}
        for name, key in keys.items()
    }
    return {"all": tally(records).to_json(), **tables}

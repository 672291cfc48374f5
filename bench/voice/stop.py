# SPDX-License-Identifier: BSD-3-Clause
"""The word "stop": said twice, in standby, while the robot moves or speaks, by each way alone.

SHARE thins the synthetic voices. Recordings of people are few, and all of them are counted.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from bench.common import resumable
from bench.voice import outcomes
from bench.voice.hearing import pieces
from bench.voice.hearing.pieces import SceneRecord
from bench.voice.hearing.replay_stream import WAYS, way_name
from bench.voice.material.mixing import StreamedTrial, chunks, trials_of, twice
from bench.voice.material.synthesis import DEV, SpokenClip, recorded
from bench.voice.outcomes import latencies, quantiles, right, tally
from bench.voice.trials import STOP, THIN, WHOLE, clips_of
from support.figures import Figure
from voice_assist.types import Mode

TWICE, PEOPLE = "said twice", "stop, human"
ROBOT = (  # [dB] below the word
    *(("servo", 10.0), ("servo", 0.0)),
    *(("speaking", 12.0), ("speaking", 6.0), ("speaking", 0.0)),
)
NAMES = {"servo": "over the robot's joints", "speaking": "over the robot's replies"}
TARGETS = {  # least share heard
    f"stop, synthetic, {TWICE}": 0.999,
    f"stop, human, {TWICE}": 0.999,
    "stop, synthetic, quiet, both ways": 0.995,
    "stop, human, quiet, both ways": 0.99,
}
ALONE, LATE = "quiet, both ways", {"p50": 100.0, "p99": 300.0}  # [ms] after the word, at most
HARD = ("theatre", 0.0)  # background and SNR [dB] in which each way is tried alone, beside quiet


def measure() -> list[Figure]:
    """Share heard and nothing else taken; synthetic voices and people apart."""
    plans = {name: chunks(plan, is_whole=PEOPLE in name) for name, plan in _plans(THIN)}
    every = pieces.measured("stop", plans)
    found = {name: records for name, records in every.items() if records}
    done = sum(map(len, found.values()))
    full = sum(len(plan) for _, plan in _plans(min(THIN, WHOLE)))
    figures = [resumable.measured(done, "trials", full)]
    for name, records in found.items():
        figures.append(right(name, tally(records), TARGETS.get(name)))
        figures += _latency(name, records)
    missed = {name: outcomes.misses(records) for name, records in found.items()}
    resumable.write_details("voice/stop_missed.json", done, missed)
    return figures


def people() -> list[SpokenClip]:
    """People who say "stop"; none where there are no recordings."""
    return [clip for clip in recorded(DEV) if clip.text in STOP]


def _plans(thin: int) -> Iterator[tuple[str, list[StreamedTrial]]]:
    synthetic = list(clips_of(STOP))
    yield f"stop, synthetic, {TWICE}", twice(synthetic)
    yield from _conditions("stop, synthetic", trials_of(synthetic)[::thin])
    if humans := people():
        yield f"{PEOPLE}, {TWICE}", twice(humans)
        yield from _conditions(PEOPLE, trials_of(humans))
    else:
        print("no human speech in ../shared/speech: people left out")


def _conditions(
    who: str, trials: Sequence[StreamedTrial]
) -> Iterator[tuple[str, list[StreamedTrial]]]:
    for way in WAYS:
        yield f"{who}, quiet, {way_name(way)}", [replace(t, way=way) for t in trials]
    background, snr = HARD
    for way in WAYS:
        noisy = [replace(t, background=background, snr=snr, way=way) for t in trials]  # type: ignore[arg-type]
        yield f"{who}, {background} {snr:g} dB, {way_name(way)}", noisy
    yield f"{who}, standby", [replace(t, mode=Mode.STANDBY.value) for t in trials]
    for kind, level in ROBOT:
        over = [replace(t, background=kind, snr=level) for t in trials]  # type: ignore[arg-type]
        yield f"{who}, {NAMES[kind]}, {level:g} dB below", over


def _latency(name: str, records: Sequence[SceneRecord]) -> list[Figure]:
    times = latencies(records).get("stop")
    if not times:
        return []
    values, limits = quantiles(times), LATE if name.endswith(ALONE) else {}
    return [Figure(f"{name}: {q}", values[q], "ms", limits.get(q)) for q in ("p50", "p99")]

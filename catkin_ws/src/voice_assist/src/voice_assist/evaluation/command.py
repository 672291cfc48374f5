# SPDX-License-Identifier: BSD-3-Clause
"""The `evaluate` verb: a manifest in, a JSON file of figures out, on several cores."""

from __future__ import annotations

import csv
import io
import json
import multiprocessing
import os
import platform
import signal
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import track

from typed_config import check_writable, replacing
from voice_assist.assembly import make_pipeline, make_recognizer
from voice_assist.config import VoiceConfig
from voice_assist.errors import ManifestError, VoiceError
from voice_assist.evaluation.evaluator import (
    ClipOutcome,
    Evaluator,
    LabelledClip,
    noise_files,
    read_manifest,
    read_noises,
    said_once,
)
from voice_assist.evaluation.metrics import summarize, verdict
from voice_assist.profile.profile import facts_of

END_OF_SPEECH = "last 10 ms of the clip within 35 dB of its loudest and 10 dB above its background"


@dataclass(frozen=True)
class Job:
    """What to evaluate, and where to write it."""

    manifest: Path
    out: Path
    mode: str
    noise: Path | None
    snr_db: float | None
    jobs: int
    details: Path | None


def evaluate(config: VoiceConfig, job: Job) -> dict[str, Any]:
    """Run all clips and write the figures.

    Raises:
        ManifestError: The manifest, a clip, the noise or the place to write cannot be used.
        ModelError: A network is missing or damaged.
        VoiceError: A process ended before its clips were done.
    """
    if (job.noise is None) != (job.snr_db is None):
        given = f"noise {job.noise}, its level {job.snr_db}"
        raise ManifestError(f"{given}: give both NOISE=dir and SNR=dB, or neither")
    config = said_once(config)
    clips = read_manifest(job.manifest, config.commands, job.mode)
    if job.noise is not None:
        read_noises(job.noise)  # refused here in one line, and not in every process
    for path in (job.out, job.details):
        if path is not None:
            _check_writable(path)
    _check_apart(job, clips)
    jobs = min(job.jobs, len(clips))
    context = _context(config, job, jobs)
    outcomes = list(_show(_run(config, job, clips, jobs), len(clips)))
    figures = {**summarize(outcomes, config.commands.phrases), **context}
    _write(job.out, json.dumps(figures, indent=2) + "\n")
    if job.details is not None:
        _write(job.details, _details(outcomes))
    _print_short(figures, job.out)
    return figures


def _run(
    config: VoiceConfig, job: Job, clips: Sequence[LabelledClip], jobs: int
) -> Iterator[ClipOutcome]:
    if jobs == 1:
        _prepare(config, job)
        yield from map(_one, clips)
        return
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(jobs, context, _prepare, (config, job)) as pool:
        try:
            # Ctrl-C is for this process alone: what it starts now inherits that it is ignored
            previous = signal.signal(signal.SIGINT, signal.SIG_IGN)
            outcomes = pool.map(_one, clips, chunksize=4)
            signal.signal(signal.SIGINT, previous)
            yield from outcomes
        except BrokenProcessPool as error:
            words = f"one of {jobs} processes ended too early, as without memory; try JOBS=1"
            raise VoiceError(words) from error
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise


_EVALUATORS: list[Evaluator] = []  # one per process, built by its start


def _prepare(config: VoiceConfig, job: Job) -> None:
    recognizer = make_recognizer(config)
    noises = read_noises(job.noise) if job.noise is not None else []
    evaluator = Evaluator(
        lambda clock: make_pipeline(config, clock, recognizer),
        job.mode,
        noises,
        job.snr_db or 0.0,
    )
    evaluator.warm_up()
    _EVALUATORS[:] = [evaluator]


def _one(clip: LabelledClip) -> ClipOutcome:
    return _EVALUATORS[0](clip)


def _show(outcomes: Iterator[ClipOutcome], total: int) -> Iterator[ClipOutcome]:
    console = Console(stderr=True)
    yield from track(
        outcomes, "clips", total=total, console=console, disable=not sys.stderr.isatty()
    )


def _context(config: VoiceConfig, job: Job, jobs: int) -> dict[str, Any]:
    recognizer = make_recognizer(config)
    make_pipeline(config, time.monotonic, recognizer)  # a damaged network is refused here
    noises = noise_files(job.noise) if job.noise else []
    return {
        "model": recognizer.name,
        "model_hash": recognizer.model_hash,
        **facts_of(recognizer),
        "mode": job.mode,
        "noise": str(job.noise) if job.noise else None,
        "noise_files": [str(path) for path in noises],
        "snr_db": job.snr_db,
        "said_twice": config.commands.said_twice,
        "noise_reduction": config.audio.denoise.mode,
        "end_of_speech": END_OF_SPEECH,
        "jobs": jobs,
        "machine": f"{platform.machine()}, {os.cpu_count()} cores",
        "python": platform.python_version(),
        "date": datetime.now(UTC).date().isoformat(),
    }


def _check_writable(path: Path) -> None:
    try:
        check_writable(path)
    except OSError as error:
        raise ManifestError(f"{path} cannot be written: {error.strerror}") from error


def _check_apart(job: Job, clips: Sequence[LabelledClip]) -> None:
    """Refuse to write over what is read, or one output over the other."""
    taken = {clip.path.resolve(): f"the clip of row {clip.row}" for clip in clips}
    taken[job.manifest.resolve()] = "the manifest"
    for path, what in ((job.out, "the file of figures"), (job.details, "the details")):
        if path is None:
            continue
        if there := taken.get(path.resolve()):
            raise ManifestError(f"{path} is {there}, so {what} cannot be written there")
        taken[path.resolve()] = what


def _write(path: Path, text: str) -> None:
    """Replace a file, all or nothing; what is no file, as /dev/stdout, is written to."""
    try:
        if path.exists() and not path.is_file():
            path.write_text(text, encoding="utf-8", newline="")
            return
        place = path.resolve()  # of a link
        with replacing(place, place.suffix) as temporary:
            temporary.write_text(text, encoding="utf-8", newline="")
    except OSError as error:
        raise ManifestError(f"{path} cannot be written: {error.strerror}") from error


def _details(outcomes: Sequence[ClipOutcome]) -> str:
    columns: dict[str, Callable[[ClipOutcome], object]] = {
        "row": lambda o: o.clip.row,
        "path": lambda o: o.clip.path,
        "transcript": lambda o: o.clip.transcript,
        "command": lambda o: o.clip.phrase,
        "verdict": lambda o: (
            verdict(o) if o.clip.phrase else ("accepted" if o.taken else "ignored")
        ),
        "taken": lambda o: "|".join(t.command for t in o.taken),
        "heard": lambda o: "|".join(o.heard),
        "why": lambda o: "|".join(o.why),
        "latency_ms": lambda o: "|".join(f"{1e3 * t.latency:.0f}" for t in o.taken),
        "confidence": lambda o: "|".join(f"{t.confidence:.3f}" for t in o.taken),
        "seconds": lambda o: f"{o.seconds:.3f}",
        "claims": lambda o: json.dumps([asdict(claim) for claim in o.claims]),
    }
    text = io.StringIO(newline="")
    writer = csv.writer(text)
    writer.writerow(columns)
    writer.writerows([[value(o) for value in columns.values()] for o in outcomes])
    return text.getvalue()


def _print_short(figures: dict[str, Any], out: Path) -> None:
    """A table for the terminal."""
    for phrase, entry in figures["commands"].items():
        if entry["n"]:
            latency = figures["latency_ms"][phrase]["p50"]
            after = "" if latency is None else f", median {latency:.0f} ms after the end of speech"
            print(f"{phrase:12} {entry['correct']}/{entry['n']} right{after}")
    negatives = figures["negatives"]
    if negatives["n"]:
        rate = f"{negatives['accepted_per_hour']:.2f} per hour"
        print(f"no command   {negatives['accepted']} taken in {negatives['n']} clips, {rate}")
    print(f"written to {out}")

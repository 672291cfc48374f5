# SPDX-License-Identifier: BSD-3-Clause
"""An hour without a break in one process: idle, talk and commands in turn, in lock-step.

Lock-step means: stream time and the CPU time of the work, so that the hour takes a quarter of one
on an idle core, and what else runs on the machine counts for nothing. Sound is made beforehand,
minute by minute, in another process, and not counted. SOAK=1 is the length [h]; it cannot be done
in several goes.
"""

from __future__ import annotations

import json
import multiprocessing
import os
import subprocess
import sys
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path

import numpy as np
from scipy.stats import linregress
from scipy.stats import t as student

from bench.voice import merge_results, theatre_noise
from bench.voice.replay_stream import whole_frames
from bench.voice.resumable import MODEL
from bench.voice.synthesis import Spoken
from bench.voice.theatre_talk import talk
from bench.voice.trials import LEAST, clips_of
from support.figures import ROOT, Figure
from voice_assist.assembly import make_pipeline
from voice_assist.audio.mixing import end_of_speech
from voice_assist.audio.source import Framer
from voice_assist.audio.wav_file import read_sound
from voice_assist.config import load_voice_config
from voice_assist.evaluation.evaluator import StreamClock
from voice_assist.pipeline.pipeline import Pipeline
from voice_assist.types import RATE, Decision, Lost, Match, Mode, Samples

FULL = 1.0  # [h]
HOURS = float(os.environ.get("SOAK", "1"))
IDLE, TALK = 20.0, 20.0  # [s] of a minute
COMMANDS, EVERY = 8, 2.5  # in the rest of it, one in so many seconds
SETTLED = 300.0  # [s] after which memory is compared with that at the end
QUIET_DB = -60.0  # [dB] of full scale behind the commands


@dataclass(frozen=True)
class Told:
    """A command in the stream."""

    text: str
    begin: float  # [s] stream time of its clip's beginning
    end: float  # [s] of its end of speech


@dataclass(frozen=True)
class Answer:
    """One that was taken."""

    text: str
    at: float  # [s] stream time
    latency: float  # [s] from the end of speech


@dataclass(frozen=True)
class Soaked:
    """What the hour came to."""

    seconds: float  # [s] of stream
    told: int
    answers: list[Answer]
    memory: list[tuple[float, float]]  # [s] of stream, resident bytes
    lost: int  # samples that the pipeline missed
    dropped: int  # frames that a queue of the node's length would have given up
    behind: float  # [s] most that the work was behind the stream
    compute: float  # [s] of CPU


def measure() -> list[Figure]:
    """Run this module as a program, so that no other part's memory counts."""
    command = [sys.executable, "-m", "bench.voice.soak"]
    done = subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True)
    data = json.loads(done.stdout.splitlines()[-1])
    answers = [Answer(**one) for one in data.pop("answers")]
    memory = [(float(at), float(size)) for at, size in data.pop("memory")]
    found = Soaked(**data, answers=answers, memory=memory)
    hours = found.seconds / 3600.0
    merge_results.write_details("soak_course", hours, asdict(found))
    return [merge_results.measured(hours, "h", FULL), *figures(found)]


def figures(found: Soaked) -> list[Figure]:
    """Memory, latency and their drift, and what was lost."""
    start = next(size for at, size in found.memory if at >= min(SETTLED, found.memory[-1][0]))
    end = found.memory[-1][1]
    times = [1e3 * a.latency for a in found.answers]
    right = len(found.answers)
    slope, error = drift([a.at / 3600.0 for a in found.answers], _about_own_median(found.answers))
    note = f"(+- {error:.1f} with 95 %; lock-step: stream time and CPU time)"
    return [
        Figure("soak: memory after five minutes", start / 1e6, "MB", 600.0),
        Figure("soak: memory at the end", end / 1e6, "MB", 600.0),
        Figure("soak: memory grown", (end - start) / 1e6, "MB", 20.0),
        Figure("soak: drift of latency, beyond chance", max(0.0, slope - error), "ms/h", 5.0),
        Figure("soak: drift of latency", slope, "ms/h", note=note),
        Figure("soak: latency p50", float(np.median(times)), "ms"),
        Figure("soak: lost samples", found.lost, "", 0.0),
        Figure("soak: frames that the queue would drop", found.dropped, "", 0.0),
        Figure("soak: most behind the stream", 1e3 * found.behind, "ms"),
        Figure("soak: taken", right / found.told, "of all", note=f"({right} of {found.told})"),
        Figure("soak: real-time factor", found.compute / found.seconds, ""),
    ]


def _about_own_median(answers: Sequence[Answer]) -> list[float]:
    """Latencies less the median of their command's, which differ between commands [ms]."""
    groups: dict[str, list[float]] = {}
    for answer in answers:
        groups.setdefault(answer.text, []).append(answer.latency)
    return [1e3 * (a.latency - float(np.median(groups[a.text]))) for a in answers]


def drift(at: Sequence[float], values: Sequence[float]) -> tuple[float, float]:
    """Slope of values over time, and half its 95 % interval, by least squares.

    Args:
        at: Times; at least three.
        values: Of each.
    """
    fit = linregress(at, values)
    width = float(student.ppf(0.975, len(at) - 2)) * float(fit.stderr)
    return float(fit.slope), width


class Soak:
    """Streams minute after minute through one pipeline that is never reset."""

    def __init__(self) -> None:
        """Load the networks."""
        config = load_voice_config(recognizer__model=MODEL)
        self._clock = StreamClock(time.process_time)
        self._pipeline: Pipeline = make_pipeline(config, self._clock)
        noise = np.random.default_rng(0).standard_normal(2 * RATE)
        self._pipeline.warm_up((0.1 * noise).astype(np.float32))
        self._framer = Framer()
        self._queue = config.audio.queue
        self._began = self._clock() + 1.0
        self._streamed = 0.0
        self.told, self.lost, self.dropped = 0, 0, 0
        self.behind = 0.0
        self.answers: list[Answer] = []
        self.memory: list[tuple[float, float]] = []

    def __call__(self, sound: Samples, told: Sequence[Told]) -> None:
        """Stream a minute, armed, in which some commands are said."""
        matches: list[tuple[float, str]] = []
        for frame in self._framer.push(sound, self._began + self._streamed):
            self._pipeline.set_mode(Mode.ACTIVE, "soak")
            arrived = frame.stamp + frame.duration
            late = max(0.0, self._clock() - arrived)
            self.behind = max(self.behind, late)
            self.dropped += late / frame.duration > self._queue
            self._clock.begin(arrived)
            events = self._pipeline(frame)
            self._clock.end()
            self.lost += sum(event.samples for event in events if isinstance(event, Lost))
            decided = (e for e in events if isinstance(e, Decision))
            matches += [
                (e.decided - self._began, e.outcome.command)
                for e in decided
                if isinstance(e.outcome, Match)
            ]
        shifted = [
            Told(one.text, one.begin + self._streamed, one.end + self._streamed) for one in told
        ]
        self.answers += answers_to(shifted, matches)
        self.told += len(told)
        self._streamed += len(sound) / RATE
        self.memory.append((self._streamed, float(_resident())))

    def result(self) -> Soaked:
        """What it came to so far."""
        return Soaked(
            self._streamed,
            self.told,
            self.answers,
            self.memory,
            self.lost,
            self.dropped,
            self.behind,
            self._clock.compute,
        )


def answers_to(told: Sequence[Told], matches: Sequence[tuple[float, str]]) -> list[Answer]:
    """The first match of each command's own words, from its beginning to the next command's.

    Args:
        told: Commands in their order.
        matches: Time [s] and command of what was taken.
    """
    found = []
    for one in told:
        until = one.begin + EVERY
        own = [at for at, command in matches if command == one.text and one.begin < at < until]
        if own:
            found.append(Answer(one.text, own[0], own[0] - one.end))
    return found


def minute(index: int, clips: Sequence[Spoken]) -> tuple[Samples, list[Told]]:
    """A minute: noise of one kind, then talk, then commands."""
    rng = np.random.default_rng((11, index))
    kinds = ("silence", "fans", "theatre", "suction")
    idle = theatre_noise.make(kinds[index % len(kinds)], IDLE, 5000 + index)
    chatter, _ = talk("synthetic", 5000 + index, TALK)
    length = round(COMMANDS * EVERY * RATE)
    quiet = (10 ** (QUIET_DB / 20) * rng.standard_normal(length)).astype(np.float32)
    told = []
    for turn in range(COMMANDS):
        clip = clips[int(rng.integers(len(clips)))]
        speech = read_sound(ROOT / clip.path)[: round((EVERY - 1.0) * RATE)]
        start = round((turn * EVERY + 0.5) * RATE)
        quiet[start : start + len(speech)] += speech
        begin = IDLE + TALK + start / RATE
        told.append(Told(clip.text, begin, begin + end_of_speech(speech)))
    return whole_frames(np.concatenate([idle, chatter, quiet])), told


def main() -> None:
    """Print what the hour came to as JSON."""
    soak = Soak()
    minutes = max(3, round(60.0 * HOURS))
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as maker:
        for index in range(minutes):
            soak(*maker.submit(_minute, index).result())
            if index % 10 == 9:
                print(f"soak: {index + 1} of {minutes} minutes", file=sys.stderr, flush=True)
    print(json.dumps(asdict(soak.result())))


@cache
def _clips() -> tuple[Spoken, ...]:
    return tuple(clip for group in LEAST for clip in clips_of(group))


def _minute(index: int) -> tuple[Samples, list[Told]]:
    return minute(index, _clips())


def _resident() -> int:
    """Resident memory of this process now [bytes]."""
    pages = int(Path("/proc/self/statm").read_text(encoding="utf-8").split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE")


if __name__ == "__main__":
    main()

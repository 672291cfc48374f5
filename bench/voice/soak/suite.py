# SPDX-License-Identifier: BSD-3-Clause
"""An hour without a break in one process: idle, talk and commands in turn, in lock-step.

Lock-step means stream time plus the CPU time of the work. So the hour takes a quarter of one on an
idle core, and other work on the machine changes nothing. Another process makes the sound in
advance, minute by minute; that time does not count. SOAK=1 is the length [h]. It cannot be done in
several goes.
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
from dataclasses import asdict, replace
from functools import cache

import numpy as np

from bench.common import resumable
from bench.system.processes import resident
from bench.voice.hearing.pieces import MODEL
from bench.voice.hearing.replay_stream import whole_frames
from bench.voice.material import theatre_noise
from bench.voice.material.synthesis import SpokenClip
from bench.voice.material.theatre_talk import talk
from bench.voice.soak.judge import (
    EVERY,
    SoakResult,
    SpokenCommand,
    TakenCommand,
    answers_to,
    figures,
)
from bench.voice.trials import MIN_TRIALS, clips_of
from support.figures import ROOT, Figure
from voice_assist.assembly import make_pipeline
from voice_assist.audio.mixing import end_of_speech
from voice_assist.audio.sound_file import read_sound
from voice_assist.audio.source import Framer
from voice_assist.config import load_voice_config
from voice_assist.evaluation.evaluator import StreamClock
from voice_assist.pipeline.pipeline import Pipeline
from voice_assist.types import RATE, Lost, Mode, Samples, UtteranceDecision

FULL = 1.0  # [h]
HOURS = float(os.environ.get("SOAK", "1"))
IDLE, TALK = 20.0, 20.0  # [s] of a minute
COMMANDS = 8  # in the rest of it
QUIET_DB = -60.0  # [dB] of full scale behind the commands


def measure() -> list[Figure]:
    """Run this module as a program, so that no other part's memory counts."""
    command = [sys.executable, "-m", "bench.voice.soak.suite"]
    done = subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True)
    data = json.loads(done.stdout.splitlines()[-1])
    answers = [TakenCommand(**one) for one in data.pop("answers")]
    memory = [(float(at), float(size)) for at, size in data.pop("memory")]
    found = SoakResult(**data, answers=answers, memory=memory)
    hours = found.seconds / 3600.0
    resumable.write_details("voice/soak_course.json", hours, asdict(found))
    return [resumable.measured(hours, "h", FULL), *figures(found)]


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
        self.said, self.lost, self.dropped = 0, 0, 0
        self.behind = 0.0
        self.answers: list[TakenCommand] = []
        self.memory: list[tuple[float, float]] = []

    def __call__(self, sound: Samples, said: Sequence[SpokenCommand]) -> None:
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
            matches += [
                (event.decided - self._began, event.command)
                for event in events
                if isinstance(event, UtteranceDecision) and event.command
            ]
        shifted = [
            replace(one, begin=one.begin + self._streamed, end=one.end + self._streamed)
            for one in said
        ]
        self.answers += answers_to(shifted, matches)
        self.said += len(said)
        self._streamed += len(sound) / RATE
        self.memory.append((self._streamed, float(resident())))

    def result(self) -> SoakResult:
        """What it came to so far."""
        return SoakResult(
            self._streamed,
            self.said,
            self.answers,
            self.memory,
            self.lost,
            self.dropped,
            self.behind,
            self._clock.compute,
        )


def minute(index: int, clips: Sequence[SpokenClip]) -> tuple[Samples, list[SpokenCommand]]:
    """A minute: noise of one kind, then talk, then commands."""
    rng = np.random.default_rng((11, index))
    kinds = ("silence", "fans", "theatre", "suction")
    idle = theatre_noise.make(kinds[index % len(kinds)], IDLE, 5000 + index)
    chatter, _ = talk("synthetic", 5000 + index, TALK)
    length = round(COMMANDS * EVERY * RATE)
    quiet = (10 ** (QUIET_DB / 20) * rng.standard_normal(length)).astype(np.float32)
    said = []
    for turn in range(COMMANDS):
        clip = clips[int(rng.integers(len(clips)))]
        speech = read_sound(ROOT / clip.path)[: round((EVERY - 1.0) * RATE)]
        start = round((turn * EVERY + 0.5) * RATE)
        quiet[start : start + len(speech)] += speech
        begin = IDLE + TALK + start / RATE
        said.append(SpokenCommand(clip.text, begin, begin + end_of_speech(speech)))
    return whole_frames(np.concatenate([idle, chatter, quiet])), said


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
def _clips() -> tuple[SpokenClip, ...]:
    return tuple(clip for group in MIN_TRIALS for clip in clips_of(group))


def _minute(index: int) -> tuple[Samples, list[SpokenCommand]]:
    return minute(index, _clips())


if __name__ == "__main__":
    main()

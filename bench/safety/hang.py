# SPDX-License-Identifier: BSD-3-Clause
"""Is a recogniser that hangs noticed, and one that only lacks a processor not?

Recognition hears talk and commands in real time, while other processes keep all cores busy. By the
clock many frames take longer than `recognizer.hung_after`; none of them may count as a hang. Then
work hangs for ever, with and without the others. Measured is the time until the watch reports it.
In the environment: BENCH_SECONDS of sound (60), BURNERS (6), HANGS of each kind (20).
"""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from bench.common.resumable import measured
from support.figures import Figure, percentiles
from support.theatre_sound import RATE, speak
from voice_assist.assembly import limit_torch, make_pipeline
from voice_assist.audio.source import Framer
from voice_assist.config import load_voice_config
from voice_assist.pipeline.hang_detection import HangWatch, waits
from voice_assist.ros.voice_node import WATCH_PERIOD

FULL, FULL_HANGS = 60.0, 20  # [s] of sound, hangs of each kind
SECONDS = float(os.environ.get("BENCH_SECONDS", FULL))
BURNERS = int(os.environ.get("BURNERS", "6"))
HANGS = int(os.environ.get("HANGS", FULL_HANGS))
HELD_WITHIN = 0.5  # [s] demanded; braking takes 0.06 s of it
LONGEST = 10.0  # [s] for a hang to be noticed
WORDS = ("hey robot", "they will release the beds before the morning", "pull more", "tense")
BURN = "while True: pass"


class WatchedThread:
    """Work in a thread of its own that another thread checks now and then."""

    def __init__(self, allowed: float) -> None:
        self.since: float | None = None
        self.used = [0.0]  # [s] that a frame had used, at each check
        self.objections = 0
        self._watch = HangWatch(allowed)

    def check(self) -> str:
        """Check once; gives the objection."""
        since, now = self.since, time.monotonic()
        words = self._watch.objection(since, now)
        self.objections += bool(words)
        self.used.append(self._watch.used(since, now))
        return words


@contextmanager
def burning(count: int) -> Iterator[None]:
    """Other processes that want a core each."""
    burners = [subprocess.Popen((sys.executable, "-c", BURN)) for _ in range(count)]
    try:
        yield
    finally:
        for burner in burners:
            burner.kill()
            burner.wait()


def recognise(seconds: float, watched: WatchedThread) -> list[float]:
    """Hear words one after the other, in real time; gives the time for each frame [s]."""
    config = load_voice_config()
    limit_torch(config)
    pipeline = make_pipeline(config, time.monotonic)
    said = np.concatenate([np.append(speak(w, "en-us+f2", 150), np.zeros(RATE)) for w in WORDS])
    sound = np.resize(said, round(seconds * RATE)).astype(np.float32)
    pipeline.warm_up(sound[: 2 * RATE])
    frames = list(Framer().push(sound, 0.0))
    begin, taken = time.monotonic(), []
    for frame in frames:
        time.sleep(max(0.0, begin + frame.first_sample / RATE - time.monotonic()))
        watched.since = started = time.monotonic()
        list(pipeline(frame))
        watched.since = None
        taken.append(time.monotonic() - started)
    return taken


def busy(allowed: float) -> tuple[list[float], WatchedThread]:
    """Recognise beside the burners; gives the time of each frame [s], and what the watch saw."""
    watched, taken = WatchedThread(allowed), list[float]()
    thread = threading.Thread(target=lambda: taken.extend(recognise(SECONDS, watched)))
    thread.start()
    while thread.is_alive():
        watched.check()
        time.sleep(WATCH_PERIOD)
    return taken, watched


def hang(allowed: float, rng: np.random.Generator) -> float:
    """Let work hang; gives the time until the watch reports it [s]."""
    watched, over = WatchedThread(allowed), threading.Event()
    threading.Thread(target=over.wait, daemon=True).start()
    time.sleep(rng.uniform(0.0, WATCH_PERIOD))
    watched.since = since = time.monotonic()
    time.sleep(rng.uniform(0.0, WATCH_PERIOD))
    while not watched.check() and time.monotonic() < since + LONGEST:
        time.sleep(WATCH_PERIOD)
    over.set()
    return time.monotonic() - since


def measure() -> list[Figure]:
    """Frames beside burners, then hangs beside them and alone."""
    allowed, rng = load_voice_config().recognizer.hung_after, np.random.default_rng(6)
    note = "" if waits() else "(this kernel reports no waits: all time counts)"
    with burning(BURNERS):
        taken, watched = busy(allowed)
        slowly = [hang(allowed, rng) for _ in range(HANGS)]
    at_once = [hang(allowed, rng) for _ in range(HANGS)]
    late = sum(one > allowed for one in taken)
    where = f"beside {BURNERS} processes that burn"
    return [
        measured(min(SECONDS / FULL, HANGS / FULL_HANGS), "of the whole", 1.0),
        Figure(f"{where}: frames heard", len(taken), ""),
        *percentiles(f"{where}: time for a frame", taken, "s"),
        Figure(f"{where}: frames that took longer than {allowed:g} s by the clock", late, ""),
        Figure(f"{where}: checks that took one for a hang", watched.objections, "", 0.0, note=note),
        Figure(f"{where}: longest time that counted", max(watched.used), "s", allowed),
        *percentiles(f"{where}: a hang to its notice", slowly, "s"),
        *percentiles("alone: a hang to its notice", at_once, "s", {100: HELD_WITHIN - 0.06}),
    ]

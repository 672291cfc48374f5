# SPDX-License-Identifier: BSD-3-Clause
"""An hour of sound that is none, armed, then a "stop" in a room that is quiet again.

Each minute is of one kind (`kinds`), through the pipeline as the voice node has it. Nothing
may be taken for a command that moves the robot, nothing may break, memory stays flat, and after
each minute a spoken "stop" has to be heard at once. Beside it: whether `SoundWatch` names the kinds
in which nobody could be heard, and leaves the others alone. Then `ends`: a "stop" right after
loud noise. In the environment: HOURS (1).
"""

from __future__ import annotations

import os
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import cycle, islice

import numpy as np

from bench.common.resumable import measured
from bench.safety.sound import ends
from bench.safety.sound.kinds import DEAF, KINDS, Block, frames
from bench.system.processes import resident
from support.figures import Figure, share
from support.theatre_sound import speak
from voice_assist.assembly import limit_torch, make_pipeline
from voice_assist.audio.capture.input_check import SoundWatch
from voice_assist.audio.capture.microphone import Microphone
from voice_assist.audio.capture.portaudio import PortAudio
from voice_assist.audio.source import Framer
from voice_assist.config import load_voice_config
from voice_assist.evaluation.evaluator import StreamClock
from voice_assist.pipeline.pipeline import Pipeline
from voice_assist.types import Match, Mode, UtteranceDecision

FULL = 1.0  # [h]
HOURS = float(os.environ.get("HOURS", FULL))
PIECE = 60.0  # [s] of one kind
SETTLED = 1.5  # [s] of a quiet room before the "stop"
AFTER = 2.0  # [s] in which it has to be heard
MEMORY = 20.0  # [MiB] of growth that is borne
WARM = 2 * len(KINDS)  # pieces before memory is first measured


@dataclass
class SoundTally:
    """What was counted."""

    seconds: float = 0.0
    taken: Counter[tuple[str, str]] = field(default_factory=Counter)  # of kind and command
    stops: list[tuple[str, bool]] = field(default_factory=list)  # kind before it, whether heard
    named: Counter[str] = field(default_factory=Counter)  # pieces by kind
    pieces: Counter[str] = field(default_factory=Counter)
    memory: list[float] = field(default_factory=list)  # [MiB] after each piece
    compute: float = 0.0  # [s] of CPU


class Garbage:
    """One stream of sound, pieces of which are bad."""

    def __init__(self) -> None:
        self._config = load_voice_config()
        limit_torch(self._config)
        self._clock = StreamClock(time.process_time)
        self._pipeline = make_pipeline(self._config, self._clock)
        self._motions = {c.phrase for c in self._config.commands.commands if c.is_motion}
        audio = self._config.audio
        source = Microphone(audio.microphone, PortAudio(), time.time, lambda _: True, print)
        self._watch = SoundWatch(source, audio.deaf_after)
        self._framer, self.tally = Framer(), SoundTally()

    @property
    def moved(self) -> int:
        """Commands that move the robot, taken from sound that held none."""
        return sum(n for (_, command), n in self.tally.taken.items() if command in self._motions)

    @property
    def hearing(self) -> tuple[Pipeline, StreamClock]:
        """The pipeline, and the clock of its stream."""
        return self._pipeline, self._clock

    def hear(self, kind: str, seed: int) -> None:
        """A piece of one kind, and the "stop" after it."""
        rng, tally = np.random.default_rng((list(KINDS).index(kind), seed)), self.tally
        taken, is_named = self._stream(KINDS[kind](PIECE, rng))
        tally.taken.update((kind, command) for command in taken)
        tally.named[kind] += is_named
        tally.pieces[kind] += 1
        said = (ends.room(SETTLED, rng), speak("stop", "en-us", 150), ends.room(AFTER, rng))
        heard, _ = self._stream(iter([(np.concatenate(said, dtype=float), 0)]))
        tally.stops.append((kind, "stop" in heard))
        tally.taken.update((kind, command) for command in heard if command != "stop")
        tally.memory.append(resident() / (1 << 20))

    def _stream(self, blocks: Iterator[Block]) -> tuple[list[str], bool]:
        """Commands taken, and whether the sound was named as one in which nobody is heard."""
        taken, is_named = [], False
        began = self._clock() + 0.1
        for frame in frames(self._framer, blocks, began):
            is_named |= bool(self._watch(frame))
            self._pipeline.set_mode(Mode.ACTIVE, "bench")
            self._clock.begin(frame.stamp + frame.duration)
            events = self._pipeline(frame)
            self._clock.end()
            self.tally.compute = self._clock.compute
            self.tally.seconds += frame.duration
            decisions = [e.outcome for e in events if isinstance(e, UtteranceDecision)]
            taken += [one.command for one in decisions if isinstance(one, Match)]
        return taken, is_named


def measure() -> list[Figure]:
    """Hear it."""
    garbage, count = Garbage(), max(1, round(HOURS * 3600.0 / PIECE))
    turns = islice(enumerate(cycle(KINDS)), count)
    for index, kind in turns:
        garbage.hear(kind, index // len(KINDS))
        print(f"{index + 1} of {count}: {kind}", flush=True)
    rests = measured(count * PIECE / 3600.0, "h", FULL)
    return [rests, *figures(garbage.tally, garbage.moved), *ends.figures(*garbage.hearing)]


def figures(tally: SoundTally, moved: int) -> list[Figure]:
    """All that was counted."""
    of_kind = Counter({f"{command} in {kind}": n for (kind, command), n in tally.taken.items()})
    heard = sum(is_heard for _, is_heard in tally.stops)
    missed = Counter(kind for kind, is_heard in tally.stops if not is_heard)
    falsely = {kind: n for kind, n in tally.named.items() if n and kind not in DEAF}
    settled = tally.memory[min(WARM, len(tally.memory)) - 1]
    return [
        Figure("bad sound: heard, armed", tally.seconds / 3600.0, "h"),
        Figure("bad sound: motions", moved, "", 0.0, note=_listed(of_kind)),
        Figure("bad sound: stops", _count(tally, "stop"), ""),
        share(
            '"stop" in a quiet room after it: heard',
            heard,
            len(tally.stops),
            100.0,
            note=f"missed: {_listed(missed)}",
        ),
        *_named(tally),
        Figure("bad sound: other minutes named so", sum(falsely.values()), "", note=str(falsely)),
        Figure("bad sound: memory grown", max(tally.memory[-1] - settled, 0.0), "MiB", MEMORY),
        Figure("bad sound: CPU time per second of it", tally.compute / tally.seconds, "s"),
    ]


def _named(tally: SoundTally) -> list[Figure]:
    """None where no such minute was heard."""
    named, deaf = (sum(counts[kind] for kind in DEAF) for counts in (tally.named, tally.pieces))
    title = "bad sound: named where nobody could be heard"
    return [share(title, named, deaf, 100.0, note=f"minutes; {', '.join(DEAF)}")] if deaf else []


def _count(tally: SoundTally, wanted: str) -> int:
    return sum(n for (_, command), n in tally.taken.items() if command == wanted)


def _listed(counts: Counter[str]) -> str:
    return "; ".join(f"{n} x {what}" for what, n in counts.most_common()) or "none"

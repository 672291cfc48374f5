# SPDX-License-Identifier: BSD-3-Clause
"""Hours in which nobody gives a command, armed; HOURS=10 for the record.

Pieces that are there are counted, those of other machines too, so that it can be done in several
goes.
"""

from __future__ import annotations

import math
import os
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import astuple, dataclass
from functools import cache

from bench.common import resumable
from bench.common.resumable import digest
from bench.voice.hearing import pieces
from bench.voice.hearing.fingerprint import outline
from bench.voice.hearing.pieces import Label, SceneRecord
from bench.voice.hearing.replay_stream import SoundScene
from bench.voice.material import theatre_noise
from bench.voice.outcomes import fired
from support.figures import Figure, rate
from voice_assist.types import RATE, Mode

FULL = 10.0  # [h]
HOURS = min(FULL, float(os.environ.get("HOURS", "0.2")))
SECONDS = 300.0  # [s] of one piece
OUTLINED = 10.0  # [s] of a kind of noise, whose outline names the way it is made
REPORTED = "reported"


@dataclass(frozen=True)
class NoiseChunk:
    """Some minutes of one kind of noise."""

    kind: str  # of theatre_noise.KINDS, or RECORDED
    seed: int
    seconds: float = SECONDS
    is_reported: bool = False  # of all of it, that the robot itself speaks

    def name(self) -> str:
        """Digest of all this, and of how its kind sounds."""
        return f"{self.kind}-{self.seed:04d}-{digest(astuple(self), _outline(self.kind))}"

    def scenes(self) -> Iterator[tuple[Label, SoundScene]]:
        """One."""
        sound = theatre_noise.make(self.kind, self.seconds, self.seed)
        label: Label = {"kind": self.kind, "seed": self.seed, "seconds": len(sound) / RATE}
        spans: tuple[tuple[float, float], ...] = ()
        if self.is_reported:
            spans = ((0.0, self.seconds),)
        elif self.kind == theatre_noise.QUOTING:  # and the lab's speech output reports so
            spans = theatre_noise.when_quoting(self.seconds, self.seed)
        yield label, SoundScene(sound, Mode.ACTIVE, robot_speaks=spans)


@cache
def _outline(kind: str) -> str:
    return outline(theatre_noise.make(kind, OUTLINED, 0))


def measure() -> list[Figure]:
    """As much of each kind; beside them replies that quote commands, where a "stop" is one."""
    kinds = _kinds()
    wanted = math.ceil(HOURS * 3600.0 / SECONDS)
    pieces.restore("nothing")
    plans = {
        "": pieces.up_to("nothing", _plan(kinds), wanted),
        theatre_noise.QUOTING: _quoting(math.ceil(wanted / len(kinds))),
        REPORTED: _reported(math.ceil(wanted / len(kinds))),
    }
    found = pieces.measured("nothing", plans)
    pieces.keep("nothing", [piece for some in plans.values() for piece in some])
    records, quoting, reported = found[""], found[theatre_noise.QUOTING], found[REPORTED]
    hours = _hours(records)
    figures = [
        resumable.measured(hours, "h", FULL),
        _figure("nothing said: taken", records, 0.0),
    ]
    for kind in dict.fromkeys(r.label["kind"] for r in records):
        some = [r for r in records if r.label["kind"] == kind]
        figures.append(_figure(f"{kind}: taken", some))
    if quoting:
        stops = [c for r in quoting for c in r.heard.taken if c == "stop"]
        note = f"(in {_hours(quoting):.2f} h; reported, so that only a stop may be taken)"
        others = sum(len(r.heard.taken) for r in quoting) - len(stops)
        figures.append(Figure("replies that quote: stops", len(stops), "", note=note))
        figures.append(Figure("replies that quote: other commands", others, "", 0.0))
    if reported:
        figures.append(_figure("replies that are reported: taken", reported))
    compute = sum(r.heard.compute for r in records)
    figures.append(Figure("real-time factor on noise", compute / (3600.0 * hours), ""))
    data = {"mode": "active", "fired": fired([*records, *quoting, *reported], "kind", "seed")}
    resumable.write_details("voice/nothing_fired.json", hours, data)
    return figures


def _kinds() -> list[str]:
    """Of sound in which nobody says a command."""
    kinds = [kind for kind in theatre_noise.KINDS if kind != theatre_noise.QUOTING]
    if not theatre_noise.recordings():
        print("no recorded noise in ../shared/speech: made noise alone")
        kinds.remove(theatre_noise.RECORDED)
    return kinds


def _quoting(count: int) -> list[NoiseChunk]:
    return [NoiseChunk(theatre_noise.QUOTING, seed) for seed in range(count)]


def _reported(count: int) -> list[NoiseChunk]:
    """Replies in which a "stop" over them is looked for all the while."""
    return [NoiseChunk("replies", seed, is_reported=True) for seed in range(count)]


def _plan(kinds: Sequence[str]) -> list[NoiseChunk]:
    count = math.ceil(FULL * 3600.0 / SECONDS)
    return [NoiseChunk(kinds[i % len(kinds)], i // len(kinds)) for i in range(count)]


def _figure(name: str, records: Sequence[SceneRecord], target: float | None = None) -> Figure:
    taken = Counter(command for r in records for command in r.heard.taken)
    hours = _hours(records)
    which = ", ".join(f"{command}: {count}" for command, count in taken.items())
    return rate(name, taken.total(), hours, target, note=which)


def _hours(records: Sequence[SceneRecord]) -> float:
    return sum(r.heard.streamed for r in records) / 3600.0

# SPDX-License-Identifier: BSD-3-Clause
"""Commands in German, Spanish, French and Japanese, as `language:=` hears them, without enrolment.

A motion is said twice, as it must be, and so is whatever must not move the robot. All needs the
model of `make languages`. Kokoro's styles speak where its packages lie; without them there are
fewer voices. One core hears all in three quarters of an hour. MINUTES=0 measures nothing, and gives
the figures of what is kept.
"""

from __future__ import annotations

import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np

from bench.common.resumable import (
    CACHE,
    MINUTES,
    digest,
    measured,
    remembered,
    share_of,
)
from bench.voice.hearing.pieces import Label, SceneRecord
from bench.voice.hearing.replay_stream import SceneListener, SceneResult, SoundScene
from bench.voice.material import language_clips
from bench.voice.material.mixing import StreamedTrial, stream_of, trials_of
from bench.voice.outcomes import another, motions, processor, right, share_of_voices, tally, voice
from support import product_code
from support.figures import Figure, percentiles
from voice_assist.assembly import limit_torch
from voice_assist.config import load_voice_config
from voice_assist.config.commands import NOT_MOTIONS
from voice_assist.recognizer.checkpoint import EMBEDDED
from voice_assist.types import RATE

LEAST_RIGHT = 97.0  # [%] in quiet; aim of the project
SNR = 15.0  # [dB] over the noise of a theatre
AGAIN = 10_000  # added to what seeds the chance of a trial
ASKED = "said once;"  # how the reason of a question begins
NAMES = {"de": "German", "es": "Spanish", "fr": "French", "ja": "Japanese"}


def measure() -> list[Figure]:
    """What of each language's commands is right, and what of its other words is taken."""
    began, figures, scenes, planned = time.monotonic(), [], 0, 0
    for language, name in NAMES.items():
        for kind, plan in _plan(language).items():
            path, some = _file(language, kind, plan), share_of(plan)
            planned += len(plan)
            if not path.is_file() and time.monotonic() - began > 60.0 * MINUTES:
                continue
            records = _heard(language, path, some)
            scenes += len(records)
            figures += OF_KIND[kind](name, records)
    return [measured(scenes, "scenes", planned), *figures]


@dataclass(frozen=True)
class SaidTwice:
    """A trial, and after about 2 s the same words again, where they are no command said once."""

    trial: StreamedTrial
    is_moving: bool = False  # the robot, all the while

    def scene(self) -> tuple[Label, SoundScene]:
        """What to stream, and what is known of it; the end is that of the last words."""
        label, heard = self.trial.scene()
        if label["text"] in NOT_MOTIONS:
            return label, replace(heard, keeps_mode=False, is_moving=self.is_moving)
        again, end, _ = stream_of(replace(self.trial, index=AGAIN + self.trial.index))
        label["end"] = len(heard.sound) / RATE + end
        sound = np.concatenate([heard.sound, again])
        return label, replace(heard, sound=sound, keeps_mode=False)


def _plan(language: str) -> dict[str, list[SaidTwice]]:
    said = trials_of(language_clips.commands(language))
    plans = {
        "commands": said,
        "noise": [replace(trial, background="theatre", snr=SNR) for trial in said],
        "near misses": trials_of(language_clips.near_misses(language)),
        "other words": trials_of(language_clips.other_words(language)),
    }
    scenes = {kind: list(map(SaidTwice, trials)) for kind, trials in plans.items()}
    stops = [trial for trial in plans["noise"] if trial.clip.text == "stop"]
    return scenes | {"in motion": [SaidTwice(trial, is_moving=True) for trial in stops]}


def _file(language: str, kind: str, plan: Sequence[SaidTwice]) -> Path:
    """Where it is kept how a set of trials was heard."""
    config = load_voice_config(language=language)
    key = digest(
        config,
        product_code.identity(product_code.LANGUAGES),
        [trial.scene()[0] for trial in share_of(plan)],
    )
    return CACHE / "languages" / f"{language}-{kind}-{key}.json"


def _heard(language: str, path: Path, plan: Sequence[SaidTwice]) -> list[SceneRecord]:
    """How trials are heard, streamed where it is not kept; what is taken is what it calls."""

    def stream() -> list[dict[str, object]]:
        listen = _listener(language)
        scenes = [trial.scene() for trial in plan]
        return [{"label": label, "heard": listen(scene).to_json()} for label, scene in scenes]

    commands = load_voice_config(language=language).commands.commands
    called = {c.phrase: c.command for c in commands}
    records = [
        SceneRecord(r["label"], SceneResult.from_json(r["heard"])) for r in remembered(path, stream)
    ]
    return [SceneRecord(r.label, _calling(r.heard, called)) for r in records]


@cache
def _listener(language: str) -> SceneListener:
    limit_torch(load_voice_config())
    return SceneListener(EMBEDDED, language=language)


def _calling(heard: SceneResult, called: dict[str, str]) -> SceneResult:
    said = tuple(replace(one, command=called.get(one.command, "")) for one in heard.said)
    return replace(heard, said=said)


def _in_quiet(name: str, records: Sequence[SceneRecord]) -> list[Figure]:
    stops = [r for r in records if r.label["text"] == "stop"]
    others = [r for r in records if r not in stops]
    figures = [*_commands(name, records, LEAST_RIGHT / 100.0)]
    figures.append(right(f'{name}: "stop" in both words', tally(stops)))
    named = {'"stop" after its end': stops, "other commands after their end": others}
    for title, some in named.items():
        late = [1e3 * (t.at - r.label["end"]) for r in some for t in r.heard.said if t.is_taken]
        figures += percentiles(f"{name}: {title}", late, "ms")
    what = "processor, while commands are said"
    return [*figures, Figure(f"{name}: {what}", processor(records), "%")]


def _in_noise(name: str, records: Sequence[SceneRecord]) -> list[Figure]:
    return _commands(f"{name}, {SNR:.0f} dB", records)


def _in_motion(name: str, records: Sequence[SceneRecord]) -> list[Figure]:
    return [right(f'{name}, {SNR:.0f} dB: "stop" while the robot moves', tally(records))]


def _commands(
    name: str, records: Sequence[SceneRecord], least: float | None = None
) -> list[Figure]:
    count = tally(records)
    note = _said(r for r in records if set(r.heard.taken) - {r.label["text"]})
    return [right(name, count, least), another(name, count, 0.0, note)]


def _near_misses(name: str, records: Sequence[SceneRecord]) -> list[Figure]:
    return _no_commands(f"{name}, near misses", records)


def _other_words(name: str, records: Sequence[SceneRecord]) -> list[Figure]:
    return _no_commands(f"{name}, other words", records)


def _no_commands(name: str, records: Sequence[SceneRecord]) -> list[Figure]:
    asked = ((voice(r), any(t.why.startswith(ASKED) for t in r.heard.said)) for r in records)
    moved = [(voice(r), not motions().isdisjoint(r.heard.taken)) for r in records]
    halted = ((voice(r), "stop" in r.heard.taken) for r in records)
    note = _said(r for r, (_, is_moved) in zip(records, moved, strict=True) if is_moved)
    title = f"{name}: said twice, taken as a motion"
    return [
        share_of_voices(f"{name}: asked for as a motion", asked, at_most=True),
        share_of_voices(title, moved, 0.0, at_most=True, note=note),
        share_of_voices(f"{name}: taken as stop", halted, at_most=True),
    ]


def _said(records: Iterable[SceneRecord]) -> str:
    return ", ".join(f"{r.label['text']} as {' and '.join(r.heard.taken)}" for r in records)


OF_KIND = {
    "commands": _in_quiet,
    "noise": _in_noise,
    "in motion": _in_motion,
    "near misses": _near_misses,
    "other words": _other_words,
}

# SPDX-License-Identifier: BSD-3-Clause
"""Networks in float32 and in the type that ships here: what is decided otherwise, and its price.

The same scenes are heard in both: one in EACH of `voice.overlap`'s (20), and every command in every
held-out native voice, in quiet and in noise. Without bfloat16 in the processor nothing is measured.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import replace

import torch

from bench.common.resumable import measured
from bench.voice import overlap
from bench.voice.hearing.pieces import MODEL, SceneRecord, Trial
from bench.voice.hearing.replay_stream import SceneListener, SceneResult
from bench.voice.material.held_out_voices import natives, spread
from bench.voice.material.mixing import trials_of
from bench.voice.material.synthesis import spoken
from bench.voice.outcomes import processor, share_of_voices, voice
from bench.voice.trials import MOTIONS, OTHERS, STOP
from support.figures import Figure
from voice_assist.assembly import limit_torch
from voice_assist.config import load_voice_config
from voice_assist.recognizer.precision import BFLOAT16, FLOAT32, dtype_for

FULL = 20  # EACH at which the plan counts as whole
EACH = int(os.environ.get("EACH", str(FULL)))
SEED = 30
SNR = 6.0  # [dB] of a command over theatre noise
SURENESS = 0.05  # [0, 1] of a decision, by which it may differ and still count as the same


def measure() -> list[Figure]:
    """Scenes that are decided otherwise, and the processor's share of each type."""
    if dtype_for("cpu") == torch.float32:
        print("this processor does not multiply bfloat16: precision left out")
        return []
    limit_torch(load_voice_config())
    plans = dict(_plans(EACH))
    exact, quick = (_heard(plans, precision) for precision in (FLOAT32, BFLOAT16))
    count, full = (sum(map(len, some.values())) for some in (plans, dict(_plans(FULL))))
    figures = [measured(count, "scenes", full)]
    for name in plans:
        both = zip(exact[name], quick[name], strict=True)
        pairs = [(voice(one), one.heard, other.heard) for one, other in both]
        otherwise = ((who, not is_same(*pair)) for who, *pair in pairs)
        figures.append(share_of_voices(f"{name}: another command", otherwise, at_most=True))
        less_sure = ((who, is_same(*pair) and not is_as_sure(*pair)) for who, *pair in pairs)
        what = f"{name}: the same, but not as sure"
        figures.append(share_of_voices(what, less_sure, at_most=True))
        for precision, records in ((FLOAT32, exact[name]), (BFLOAT16, quick[name])):
            figures.append(Figure(f"{name}: processor, {precision}", processor(records), "%"))
    return figures


def is_same(one: SceneResult, other: SceneResult) -> bool:
    """Whether the same commands were taken in the same order."""
    return one.taken == other.taken


def is_as_sure(one: SceneResult, other: SceneResult) -> bool:
    """Whether the commands taken are as sure, to within SURENESS."""
    sure = ([s.confidence for s in result.said if s.is_taken] for result in (one, other))
    return all(abs(a - b) <= SURENESS for a, b in zip(*sure, strict=True))


def _plans(each: int) -> Iterator[tuple[str, Sequence[Trial]]]:
    clips = spoken(spread((*MOTIONS, *STOP, *OTHERS), natives().present, 1, SEED))
    quiet = trials_of(clips)
    noisy = [replace(trial, background="theatre", snr=SNR) for trial in quiet[::2]]
    yield "commands", [*quiet, *noisy]
    over = [trial for trials in dict(overlap.plans()).values() for trial in trials]
    for is_moving, state in overlap.STATES.items():
        if some := [t for t in over if t.is_moving is is_moving][::each]:
            yield f'talk, "stop" in most of it, {state}', some


def _heard(plans: dict[str, Sequence[Trial]], precision: str) -> dict[str, list[SceneRecord]]:
    listener = SceneListener(MODEL, recognizer__precision=precision)

    def record(trial: Trial) -> SceneRecord:
        label, scene = trial.scene()
        return SceneRecord(label, listener(scene))

    return {name: [record(trial) for trial in trials] for name, trials in plans.items()}

# SPDX-License-Identifier: BSD-3-Clause
"""The order of lessons: short and clear first, then everything, then in pieces.

A run that continues a checkpoint of an earlier one has a single lesson: pieces again,
with more of what that checkpoint got wrong, in louder noise; or, once near misses have made
it slow to write a command in noise, with more commands among them; or with many twins, which
differ from a command by a sound or two; or with neural voices, accents and words of other
languages; or with what begins like a command, and with amounts. One that starts from a Whisper
model, which hears well already, first learns to write in letters, then has that lesson too.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from voice_assist.training.data.augment import Strength


@dataclass(frozen=True)
class TrainingStage:
    """What is trained on up to a step."""

    until: int  # step
    weights: Mapping[str, float]  # relative frequency by kind of item
    seconds: float  # of sound per batch
    longest: float  # [s] of an item
    how: Strength
    needs_word_times: bool  # found by the model itself when the stage begins


GENTLE = Strength(
    speed=(0.9, 1.1), lead=(0.02, 0.3), room=0.15, noise=0.4, snr=(10.0, 35.0), warp=0.06
)

# Human speech always comes with its transcript, and people say commands too.
SHORT = {
    **{"command": 25, "variant": 5, "near": 14, "span": 24, "noise": 2},
    **{"human stop": 3, "human rare": 5, "human close": 3, "human word": 9, "sentence": 10},
}
WHOLE = {
    **{"command": 20, "variant": 6, "near": 11, "span": 16, "noise": 3},
    **{"human stop": 4, "human rare": 5, "human close": 3, "human word": 7, "sentence": 25},
}
PIECES = {
    **{"command": 13, "wake": 3, "variant": 5, "near": 16, "span": 9, "noise": 4},
    **{"human stop": 4, "human rare": 4, "human close": 2, "human word": 5, "sentence": 3},
    **{"human span": 22, "cut": 6, "splice": 8, "mined": 4},
}

MENDING = {
    **{"command": 14, "wake": 4, "variant": 5, "near": 24, "span": 8, "noise": 4},
    **{"human stop": 4, "human rare": 4, "human close": 6, "human word": 6, "sentence": 3},
    **{"human span": 18, "human cut": 4, "cut": 6, "splice": 9, "mined": 5},
}
BALANCED = {
    **{"command": 24, "wake": 6, "variant": 6, "near": 22, "span": 7, "noise": 4},
    **{"human stop": 4, "human rare": 4, "human close": 6, "human word": 6, "sentence": 3},
    **{"human span": 16, "human cut": 4, "cut": 6, "splice": 8, "mined": 5},
}
TWINNED = {
    **{"command": 28, "wake": 6, "variant": 6, "near": 16, "twin": 10, "span": 6, "noise": 4},
    **{"human stop": 5, "human rare": 4, "human close": 6, "human word": 6, "sentence": 3},
    **{"human span": 14, "human cut": 4, "cut": 6, "splice": 8, "mined": 5},
}
VOICED = {
    **{**TWINNED, "command": 20, "neural": 26, "neural near": 14, "neural span": 6},
    **{"accent": 12, "accent near": 5, "foreign": 12, "human stop": 8, "human word": 16},
    **{"human close": 8, "human span": 26, "sentence": 6},
}
BEGUN = {
    **{**VOICED, "beginning": 20, "human onset": 30, "human cut": 8, "human span": 20},
    **{"twin": 14, "human stop": 10, "human close": 10},
}
COUNTED = {**BEGUN, "command": 34, "wake": 8, "variant": 8, "amount": 12}
HARSH = Strength(snr=(-3.0, 25.0), noise=0.8, warp=0.12, telephone=0.06)

STAGES = (
    TrainingStage(900, SHORT, 64.0, 3.5, GENTLE, False),
    TrainingStage(1400, WHOLE, 80.0, 7.8, Strength(), False),
    TrainingStage(1_000_000, PIECES, 80.0, 7.8, Strength(), True),
)

_WEIGHTS = {
    **{"mending": MENDING, "balanced": BALANCED, "twins": TWINNED},
    **{"beginnings": BEGUN, "amounts": COUNTED, "voices": VOICED},
}
CONTINUED = {
    lesson: (TrainingStage(1_000_000, weights, 80.0, 7.8, HARSH, True),)
    for lesson, weights in _WEIGHTS.items()
}
LESSONS = tuple(CONTINUED)
WRITING = TrainingStage(400, WHOLE, 80.0, 7.8, Strength(), False)  # in letters


def stage_of(step: int, stages: Sequence[TrainingStage] = STAGES) -> tuple[int, TrainingStage]:
    """The stage that a step belongs to, with its number."""
    return next((n, stage) for n, stage in enumerate(stages) if step < stage.until)

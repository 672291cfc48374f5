# SPDX-License-Identifier: BSD-3-Clause
"""Amounts and their near misses in held-out voices: is a wrong number or unit ever taken?

Each clip goes through the node's pipeline, armed, with amounts on. In the environment: COUNT the
clips (3,000), MODEL another recogniser than the shipped one, such as a file of `convert-model`.
"""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from random import Random

import numpy as np
import soundfile

from bench.common import resumable
from bench.voice.hearing.pieces import MODEL
from bench.voice.hearing.replay_stream import SceneListener, SoundScene
from bench.voice.material.held_out_voices import natives, spread
from bench.voice.material.synthesis import SpokenClip, spoken
from support.figures import ROOT, Figure, share
from support.product_code import HEARING, identity
from voice_assist.assembly import limit_torch
from voice_assist.config import load_voice_config
from voice_assist.config.commands import AmountCommand
from voice_assist.text.amounts import canonical
from voice_assist.text.normalize import normalize
from voice_assist.types import RATE, Mode

COUNT = int(os.environ.get("COUNT", "3000"))
SEED = 33
BLOCK = 100  # clips that are kept together
QUIET = 0.6  # [s] before and behind the words
HUM = 1e-3  # RMS of the room's noise, full scale 1
LARGEST = "asked"  # what a large amount comes to
NEAR = (  # other numbers, other units, half a command, a number denied or in a sentence
    *("pull ten millimetres more", "pull nine millimetres more", "pull five millimetres less"),
    *("pull twelve millimetres more", "pull twenty millimetres less", "pull four millimetres more"),
    *("pull thirty millimetres more", "pull one hundred millimetres more"),
    *("pull one point two millimetres more", "pull two and a half millimetres less"),
    *("pull two newtons more", "pull two centimetres more", "pull one metre more"),
    *("two newtons less", "ten newtons more", "five newtons less", "half a millimetre more"),
    *("pull two more", "pull three less", "pull millimetres more", "tension one", "tension two"),
    *("tension five", "tension ten newtons", "tension nine point five", "tension one point nine"),
    *("do not pull two millimetres more", "we pull three millimetres more on the left"),
    *("she said half a newton less", "the tension is one point five", "one newton is more"),
)


def measure() -> list[Figure]:
    """Shares of right, wrong and refused amounts."""
    clips = material()
    named = digest_of_voice()
    outcomes: list[str] = []
    for begin in range(0, len(clips), BLOCK):
        block = clips[begin : begin + BLOCK]
        path = resumable.CACHE / "amounts" / f"{named}-{resumable.digest(block)}.json"
        outcomes += resumable.remembered(path, partial(_heard, block))
    pairs = list(zip(clips, outcomes, strict=True))
    resumable.write_details("voice/amounts_taken.json", len(pairs), wrong_or_taken(pairs))
    return [resumable.measured(len(pairs), "clips", 3000), *figures(pairs)]


def texts() -> dict[str, str]:
    """What is said, with the command that it is; empty: it is none."""
    commands = load_voice_config(commands__amounts=True).commands
    made = [c for c in commands.commands if isinstance(c, AmountCommand)]
    said = {c.phrase: c.phrase for c in made}
    return {**said, **dict.fromkeys(NEAR, "")}


def material() -> list[SpokenClip]:
    """Clips in the voices that training never used, half of them amounts."""
    every = spread(list(texts()), natives().present, 4, SEED)
    rng = Random(SEED)
    amounts = [p for p in every if texts()[p.text]]
    near = [p for p in every if not texts()[p.text]]
    half = COUNT // 2
    some = rng.sample(amounts, min(half, len(amounts))) + rng.sample(near, min(half, len(near)))
    return spoken(sorted(some, key=lambda p: (p.engine, p.voice, p.text, p.rate)))


def figures(pairs: Sequence[tuple[SpokenClip, str]]) -> list[Figure]:
    """Of clips and what was taken of each."""
    meant = texts()
    said = [(clip, taken) for clip, taken in pairs if meant[clip.text]]
    near = [(clip, taken) for clip, taken in pairs if not meant[clip.text]]
    wrong = [taken for clip, taken in pairs if is_wrong(meant[clip.text], taken)]
    right = [taken for clip, taken in said if _command(taken) == meant[clip.text]]
    asked = [taken for taken in right if taken.startswith(LARGEST)]
    fixed = [t for _, t in pairs if t and t in load_voice_config().commands.phrases]
    name = Path(MODEL).stem
    return [
        share(f"{name}: a wrong amount taken or asked for", len(wrong), len(pairs), 0.0, True),
        share(f"{name}: near misses taken as an amount", _amounts(near), len(near), 0.0, True),
        share(f"{name}: amounts taken or asked for rightly", len(right), len(said)),
        share(f"{name}: of these asked for first", len(asked), max(len(right), 1)),
        share(f"{name}: taken as a command without an amount", len(fixed), len(pairs)),
    ]


def is_wrong(meant: str, taken: str) -> bool:
    """Whether an amount was taken or asked for that was not said."""
    return bool(taken) and _is_amount(taken) and _command(taken) != meant


def wrong_or_taken(pairs: Sequence[tuple[SpokenClip, str]]) -> dict[str, int]:
    """What was taken of which words, and how often, without what was right."""
    meant = texts()
    odd = (
        f"{clip.text} -> {taken}"
        for clip, taken in pairs
        if taken and _command(taken) != meant[clip.text]
    )
    return dict(Counter(odd).most_common())


def digest_of_voice() -> str:
    """Key of all that decides what is heard."""
    return resumable.digest(identity(HEARING), MODEL, QUIET, HUM)


def _amounts(pairs: Sequence[tuple[SpokenClip, str]]) -> int:
    return sum(1 for _, taken in pairs if _is_amount(taken))


def _is_amount(taken: str) -> bool:
    return bool(taken) and bool(texts().get(_command(taken)))


def _command(taken: str) -> str:
    return taken.removeprefix(f"{LARGEST} ")


def _heard(clips: Sequence[SpokenClip]) -> list[str]:
    """What was taken of each clip; empty: nothing."""
    limit_torch(load_voice_config())
    listen = SceneListener(MODEL, commands__amounts=True)
    return [_outcome(listen, clip) for clip in clips]


def _outcome(listen: SceneListener, clip: SpokenClip) -> str:
    sound, rate = soundfile.read(ROOT / clip.path, dtype="float32")
    if rate != RATE:
        raise ValueError(f"{clip.path}: {rate} Hz, allowed: {RATE}")
    quiet = np.zeros(round(QUIET * RATE), np.float32)
    stream = np.concatenate([quiet, sound, quiet])
    stream += HUM * np.random.default_rng(SEED).standard_normal(len(stream)).astype(np.float32)
    for said in listen(SoundScene(stream, Mode.ACTIVE)).said:
        if said.is_taken:
            return said.command
        if said.why.startswith("a large amount"):
            return f"{LARGEST} {' '.join(canonical(normalize(said.text)))}"
    return ""

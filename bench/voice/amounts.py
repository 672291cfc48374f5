# SPDX-License-Identifier: BSD-3-Clause
"""Amounts and their near misses in held-out voices: is a wrong number or unit ever taken?

Each clip goes through the node's pipeline, armed, with amounts on. Pieces of 50 clips are spoken,
heard and kept; MINUTES ends a go, and the next one goes on. In the environment: COUNT the clips
(3,000), MODEL another recogniser than the shipped one, such as a file of `convert-model`.
"""

from __future__ import annotations

import json
import os
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from random import Random
from typing import Any

import numpy as np

from bench.common import resumable
from bench.voice.hearing.pieces import MODEL
from bench.voice.hearing.replay_stream import SceneListener, SceneResult, SoundScene
from bench.voice.material.held_out_voices import SyntheticVoice, natives, spread
from bench.voice.outcomes import share_of_voices
from support.figures import Figure
from support.product_code import HEARING, identity
from voice_assist.assembly import limit_torch
from voice_assist.config import load_voice_config
from voice_assist.config.commands import AmountCommand
from voice_assist.text.amounts import canonical
from voice_assist.text.normalize import normalize
from voice_assist.training.data.voices import Prompt, speak_in_turn
from voice_assist.types import FULL_SCALE, RATE, Mode, Samples

COUNT = int(os.environ.get("COUNT", "3000"))
SEED = 33
BLOCK = 50  # clips that are kept together
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


@dataclass(frozen=True)
class HeardClip:
    """A clip and what was taken of it."""

    text: str  # that was said
    voice: str
    written: str  # by the recogniser
    taken: str  # command that was taken; behind LARGEST: that was asked for; empty: none
    compute: float  # [s] of processor
    seconds: float  # [s] of sound


def measure() -> list[Figure]:
    """Shares of right, wrong and refused amounts, and what hearing a clip costs."""
    folder, blocks = resumable.CACHE / "amounts" / digest_of_voice(), plan(natives().present)
    jobs = [(block, folder / f"{resumable.digest(block)}.json") for block in blocks]
    with resumable.pool(resumable.JOBS, _prepare) as pool:
        done = list(resumable.carried_out("amounts", jobs, _heard, pool))
    heard = [HeardClip(**one) for path in done for one in json.loads(path.read_text())]
    resumable.write_details("voice/amounts_taken.json", len(heard), wrong_or_taken(heard))
    return [resumable.measured(len(heard), "clips", 3000), *figures(heard)]


@cache
def texts() -> dict[str, str]:
    """What is said, with the command that it is; empty: it is none."""
    commands = load_voice_config(commands__amounts=True).commands
    made = [c for c in commands.commands if isinstance(c, AmountCommand)]
    said = {c.phrase: c.phrase for c in made}
    return {**said, **dict.fromkeys(NEAR, "")}


def plan(cast: Sequence[SyntheticVoice]) -> list[tuple[Prompt, ...]]:
    """Prompts in some voices, half of them amounts, in pieces.

    They are in an order by chance, so that a part is like the whole.
    """
    every = spread(list(texts()), cast, 4, SEED)
    rng = Random(SEED)
    amounts = [p for p in every if texts()[p.text]]
    near = [p for p in every if not texts()[p.text]]
    rng.shuffle(amounts)
    rng.shuffle(near)
    half, each = COUNT // 2, BLOCK // 2
    begins = range(0, min(half, len(amounts), len(near)), each)
    return [(*amounts[i : i + each], *near[i : i + each]) for i in begins]


def figures(heard: Sequence[HeardClip]) -> list[Figure]:
    """Of clips and what was taken of each."""
    meant, fixed = texts(), load_voice_config().commands.phrases
    said = [one for one in heard if meant[one.text]]
    near = [one for one in heard if not meant[one.text]]

    def is_right(one: HeardClip) -> bool:
        return _command(one.taken) == meant[one.text]

    def is_of_another(one: HeardClip) -> bool:
        return is_wrong(meant[one.text], one.taken)

    def is_asked_for(one: HeardClip) -> bool:
        return one.taken.startswith(LARGEST)

    def is_plain(one: HeardClip) -> bool:
        return one.taken in fixed

    cost = sum(one.compute for one in heard) / len(heard)
    seconds = sum(one.seconds for one in heard) / len(heard)
    name, right = Path(MODEL).stem, list(filter(is_right, said))
    return [
        _share(f"{name}: a wrong amount taken or asked for", heard, is_of_another, 0.0, True),
        _share(f"{name}: near misses taken as an amount", near, _is_amount, 0.0, True),
        _share(f"{name}: amounts taken or asked for rightly", said, is_right),
        _share(f"{name}: of these asked for first", right, is_asked_for),
        _share(f"{name}: taken as a command without an amount", heard, is_plain, None, True),
        Figure(f"{name}: processor time per clip", cost, "s", note=f"of {seconds:.1f} s of sound"),
    ]


def _share(
    name: str,
    some: Sequence[HeardClip],
    counts: Callable[[HeardClip], bool],
    target: float | None = None,
    at_most: bool = False,
) -> Figure:
    trials = [(one.voice, counts(one)) for one in some] or [("", False)]
    return share_of_voices(name, trials, target, at_most)


def is_wrong(meant: str, taken: str) -> bool:
    """Whether an amount was taken or asked for that was not said."""
    command = _command(taken)
    return bool(texts().get(command)) and command != meant


def wrong_or_taken(heard: Sequence[HeardClip]) -> dict[str, int]:
    """What was taken of which words, and how often, without what was right."""
    meant = texts()
    odd = (
        f"{one.text} -> {one.taken}"
        for one in heard
        if one.taken and _command(one.taken) != meant[one.text]
    )
    return dict(Counter(odd).most_common())


def digest_of_voice() -> str:
    """Key of all that decides what is heard."""
    return resumable.digest(identity(HEARING), MODEL, QUIET, HUM)


def _is_amount(one: HeardClip) -> bool:
    return bool(one.taken) and bool(texts().get(_command(one.taken)))


def _command(taken: str) -> str:
    return taken.removeprefix(f"{LARGEST} ")


_LISTENERS: list[SceneListener] = []  # one per process, built by its start


def _prepare() -> None:
    limit_torch(load_voice_config())
    _LISTENERS[:] = [SceneListener(MODEL, commands__amounts=True)]


def _heard(prompts: Sequence[Prompt]) -> list[dict[str, Any]]:
    """A piece: each prompt is spoken and heard; one that an engine cannot say is left out."""
    by_voice = sorted(prompts, key=lambda p: (p.engine, p.voice))
    return [
        asdict(_of_clip(prompt, sound / np.float32(FULL_SCALE)))
        for prompt, sound in speak_in_turn(by_voice)
        if sound is not None
    ]


def _of_clip(prompt: Prompt, sound: Samples) -> HeardClip:
    quiet = np.zeros(round(QUIET * RATE), np.float32)
    stream = np.concatenate([quiet, sound, quiet])
    stream += HUM * np.random.default_rng(SEED).standard_normal(len(stream)).astype(np.float32)
    found = _LISTENERS[0](SoundScene(stream, Mode.ACTIVE))
    written = "; ".join(said.text for said in found.said)
    spent = round(found.compute, 3), round(found.streamed, 2)
    return HeardClip(prompt.text, f"{prompt.engine}:{prompt.voice}", written, _taken(found), *spent)


def _taken(found: SceneResult) -> str:
    """The first command that was taken or asked for; empty: none."""
    for said in found.said:
        if said.is_taken:
            return said.command
        if said.why.startswith("a large amount"):
            return f"{LARGEST} {' '.join(canonical(normalize(said.text)))}"
    return ""

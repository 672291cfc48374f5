# SPDX-License-Identifier: BSD-3-Clause
"""What the verifier learns from: commands in many voices, and words of nine other languages.

Sound is varied, goes through the recogniser's lower blocks once, and is kept as means of states
along each phrase that it could be.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
import torch
from numpy.random import Generator
from numpy.typing import NDArray

from voice_assist.audio.espeak import Int16
from voice_assist.recognizer.ctc import best_alignment
from voice_assist.recognizer.hybrid import WhisperCtc, encode_lower, encode_upper
from voice_assist.recognizer.mel import log_mel
from voice_assist.recognizer.verification import BLOCKS, segments
from voice_assist.recognizer.vocabulary import encode
from voice_assist.training.array_file import write_arrays
from voice_assist.training.data import voices
from voice_assist.training.data.augment import Strength, add_background, colour, resample_linear
from voice_assist.training.data.foreign_words import WORDS
from voice_assist.training.data.noise import Surroundings
from voice_assist.training.data.synthesis import cast_voice
from voice_assist.training.data.texts import phrases
from voice_assist.training.data.voices import Prompt
from voice_assist.types import RATE

PHRASES = ("tense", "release", "pull more", "pull less")  # commands that move the robot
HOW = Strength(speed=(0.92, 1.08), noise=0.6)
_LEAD, _TAIL = (0.1, 0.6), (0.12, 0.3)  # [s] of quiet, as endpointing leaves it
_ADDED = 2400  # samples of silence that the pipeline puts behind a settled transcript
_COMMANDS, _ACCENTED = 250, 200  # clips of each phrase: any voice, and voices of other languages
_TAKES = 3  # voices for each word
_UNLIKE = -1.2  # [nat] for each letter of a phrase below which a sound would not be taken for it


@dataclass(frozen=True)
class Said:
    """A text in a voice, and the command that it is; empty: none."""

    prompt: Prompt
    command: str


@dataclass(frozen=True, eq=False)
class Examples:
    """Of one phrase."""

    seen: NDArray[np.float32]  # (n, (letters + 4) * d)
    is_said: NDArray[np.bool_]  # (n,)
    voices: NDArray[np.str_]  # (n,)


@dataclass(frozen=True, eq=False)
class Seen:
    """What the verifier sees of one phrase in one clip."""

    phrase: str
    states: NDArray[np.float32]  # as Examples.seen has them
    is_said: bool
    voice: str


def plan(seed: int) -> list[Said]:
    """Commands and strange words, in voices for training.

    English words that are nearly commands are none of them. With them the classifiers refuse
    commands in accents: "pool more" is "pull more" in Scotland.
    """
    rng = Random(seed)
    variants, _ = voices.espeak_variants()
    found = []
    for phrase in PHRASES:
        found += [Said(cast_voice(phrase, variants, rng), phrase) for _ in range(_COMMANDS)]
        for _ in range(_ACCENTED):
            voice = f"{rng.choice(voices.FOREIGN)}+{rng.choice(variants)}"
            found.append(Said(Prompt(phrase, "phonemes", voice, *voices.random_style(rng)), phrase))
    for language, words in WORDS.items():
        for text in phrases(words):
            for _ in range(_TAKES):
                voice = f"{language}+{rng.choice(variants)}"
                found.append(Said(Prompt(text, "espeak", voice, *voices.random_style(rng)), ""))
    return found


def varied(sound: Int16, around: Surroundings, rng: Generator) -> NDArray[np.float32]:
    """A clip at another speed, in a room and in noise, with quiet around it. Shape (n,)."""
    faster = resample_linear(sound, rng.uniform(*HOW.speed))
    before, behind = (round(rng.uniform(*span) * RATE) for span in (_LEAD, _TAIL))
    placed = torch.from_numpy(np.pad(faster, (before, behind)))[None]
    noisy = add_background(colour(placed, around, HOW, rng), around, HOW, rng)[0].numpy()
    return np.pad(noisy.clip(-1.0, 1.0), (0, _ADDED)).astype(np.float32)


def phrase_segments(
    model: WhisperCtc, sound: NDArray[np.float32], command: str
) -> Iterator[tuple[str, NDArray[np.float32]]]:
    """Phrases that a sound is like, and what the verifier sees of each.

    Args:
        model: The recogniser.
        sound: Shape (n,).
        command: That is said; empty: none, and the sound may be like several.
    """
    with torch.inference_mode():
        hidden = encode_lower(model.whisper.encoder, log_mel(torch.from_numpy(sound)[None]), BLOCKS)
        ctc = model.ctc_logprobs(encode_upper(model.whisper.encoder, hidden, BLOCKS))[0].numpy()
    for phrase in (command,) if command else PHRASES:
        score, frames = best_alignment(ctc, np.array(encode(phrase)))
        if score >= _UNLIKE * len(phrase):
            yield phrase, segments(hidden[0].numpy(), frames)


def save(found: Sequence[Seen], path: Path) -> None:
    """Keep what was seen, one file for all phrases, all or nothing."""
    kept: dict[str, Any] = {}
    for number, phrase in enumerate(PHRASES):
        some = [one for one in found if one.phrase == phrase]
        kept[f"seen_{number}"] = np.stack([one.states for one in some]).astype(np.float16)
        kept[f"is_said_{number}"] = np.array([one.is_said for one in some])
        kept[f"voices_{number}"] = np.array([one.voice for one in some])
    write_arrays(path, **kept)


def load(path: Path) -> dict[str, Examples]:
    """What `save` kept, by phrase."""
    with np.load(path) as kept:
        return {
            phrase: Examples(
                kept[f"seen_{number}"].astype(np.float32),
                kept[f"is_said_{number}"],
                kept[f"voices_{number}"],
            )
            for number, phrase in enumerate(PHRASES)
        }

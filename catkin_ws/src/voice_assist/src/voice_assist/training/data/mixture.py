# SPDX-License-Identifier: BSD-3-Clause
"""What each training batch is made of: kinds of item and how often each comes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from numpy.random import Generator

from voice_assist.audio.espeak import Int16
from voice_assist.training.data.synthesis import TrainingClip
from voice_assist.training.data.texts import COMMANDS, TWINS
from voice_assist.types import RATE

LONGEST = 7.8  # [s] of an item; slowed and with quiet it fits the encoder
MAX_LETTERS = 180  # of an item; the decoder has 192 positions
WAKE = "hey robot"  # many people, and late endpointing, drop its first sound
NOTHING = np.zeros(0, np.int16)

T = TypeVar("T")


@dataclass(frozen=True)
class WordTime:
    """When a word of a clip is said, from the model's own CTC alignment."""

    word: str
    start: float  # [s] onset of its first character
    end: float  # [s] release of its last character


@dataclass(frozen=True, eq=False)
class Item:
    """One sound to train on before augmentation."""

    samples: Int16  # (n,), 16 kHz mono; empty for noise only
    text: str


@dataclass(frozen=True, eq=False)
class Aligned:
    """A clip whose word times are known."""

    clip: TrainingClip
    words: tuple[WordTime, ...]


RARE = ("more", "less", "pull", "release", "robot", "hey", "tense")
ONSETS = "sptrj"  # letters with which a command, or what is taken for one, begins
CLOSE = ("up", "go", "down", "on", "off", "no")  # short words of people near to "stop"


class Mixture:
    """Draws items by weight; every kind is a function of chance alone."""

    def __init__(
        self,
        clips: Sequence[TrainingClip],
        aligned: Sequence[Aligned],
        weights: Mapping[str, float],
        longest: float = LONGEST,
    ) -> None:
        """Sort clips into kinds.

        Args:
            clips: Synthetic and human training clips.
            aligned: Those with word times; without any, spans are not drawn.
            weights: By kind; kinds without clips are left out.
            longest: Longer clips are drawn in pieces only [s].
        """
        short = [
            clip
            for clip in clips
            if len(clip.samples) <= longest * RATE and len(clip.text) <= MAX_LETTERS
        ]
        kinds = _sources(short, aligned)
        self._sources = [kinds[kind] for kind in weights if kind in kinds]
        share = np.array([weights[kind] for kind in weights if kind in kinds], float)
        self._share = share / share.sum()

    def draw(self, rng: Generator) -> Item:
        """One random item."""
        source = self._sources[rng.choice(len(self._sources), p=self._share)]
        return source(rng)


Source = Callable[[Generator], Item]


def _sources(clips: Sequence[TrainingClip], aligned: Sequence[Aligned]) -> dict[str, Source]:
    kinds: dict[str, list[TrainingClip]] = {}
    for clip in clips:
        kinds.setdefault(_name(clip), []).append(clip)
    sources: dict[str, Source] = {name: _whole(found) for name, found in kinds.items()}
    wake = [clip for clip in kinds.get("command", []) if clip.text == WAKE]
    if wake:
        sources["wake"] = lambda rng: clipped_onset(_pick(wake, rng), rng)
    twins = [clip for clip in kinds.get("near", []) if clip.text in TWINS]
    if twins:
        sources["twin"] = _whole(twins)
    sources["noise"] = lambda rng: Item(NOTHING, "")
    human = [a for a in aligned if a.clip.kind == "sentence"]
    if human:
        sources["human span"] = lambda rng: _item(span(_pick(human, rng), rng).clip)
        sources["human cut"] = lambda rng: cut_short(span(_pick(human, rng), rng, 4), rng)
    onsets = [(a, i) for a in human for i, word in enumerate(a.words) if _begins(word.word)]
    if onsets:
        sources["human onset"] = lambda rng: _onset(*_pick(onsets, rng), rng)
    synthetic = [a for a in aligned if a.clip.kind != "sentence"]
    if synthetic:
        sources["cut"] = lambda rng: cut_short(_pick(synthetic, rng), rng)
        people = [c for name, found in kinds.items() if name.startswith("human") for c in found]
        near = [clip for clip in kinds.get("near", []) if " " not in clip.text]
        words = (people, near, kinds.get("command", []))
        parts = [_whole(found) for found in words if found]
        parts += [sources["human span"]] if human else []
        sources["splice"] = lambda rng: splice(parts, rng)
    mined = [(a, i) for a in human for i, w in enumerate(a.words) if w.word in RARE]
    if mined:
        sources["mined"] = lambda rng: _around(*_pick(mined, rng), rng)
    return sources


def span(aligned: Aligned, rng: Generator, longest: int = 6) -> Aligned:
    """One to so many consecutive words of a sentence."""
    words = aligned.words
    length = min(int(rng.integers(1, longest + 1)), len(words))
    first = int(rng.integers(len(words) - length + 1))
    return excerpt(aligned, first, first + length)


def excerpt(aligned: Aligned, first: int, last: int) -> Aligned:
    """Words first..last-1 with half of the gaps around them."""
    words, samples = aligned.words, aligned.clip.samples
    total = len(samples) / RATE
    before = words[first - 1].end if first else 0.0
    after = words[last].start if last < len(words) else total
    start = max(words[first].start - 0.15, (before + words[first].start) / 2)
    end = min(words[last - 1].end + 0.20, (words[last - 1].end + after) / 2)
    kept = tuple(WordTime(w.word, w.start - start, w.end - start) for w in words[first:last])
    sound = samples[int(start * RATE) : int(end * RATE)]
    text = " ".join(word.word for word in kept)
    return Aligned(replace(aligned.clip, samples=sound, text=text), kept)


def _begins(word: str) -> bool:
    """Whether a word begins like a command and is none."""
    return word[0] in ONSETS and word not in COMMANDS


def _onset(aligned: Aligned, index: int, rng: Generator) -> Item:
    """A word alone, broken off."""
    return cut_short(excerpt(aligned, index, index + 1), rng)


def cut_short(aligned: Aligned, rng: Generator) -> Item:
    """The sound broken off, with the words and letters that were still heard."""
    words = aligned.words
    index = int(rng.integers(len(words)))
    word = words[index]
    share = float(rng.uniform(0.0, 0.85))
    end = word.start + share * (word.end - word.start)
    heard = [w.word for w in words[:index]]
    letters = max(int(len(word.word) * (share - 0.15)), 0)
    heard += [word.word[:letters]] if letters else []
    return Item(aligned.clip.samples[: max(int(end * RATE), 1)], " ".join(heard))


def clipped_onset(clip: TrainingClip, rng: Generator) -> Item:
    """A clip without up to 90 ms of its beginning."""
    return Item(clip.samples[int(rng.uniform(0.0, 0.09) * RATE) :], clip.text)


def splice(parts: Sequence[Source], rng: Generator) -> Item:
    """Two or three short items of any origin in a row."""
    items = [_pick(parts, rng)(rng) for _ in range(rng.integers(2, 4))]
    sounds: list[Int16] = []
    for item in items:
        gap = np.zeros(int(rng.uniform(0.03, 0.4) * RATE), np.int16)
        peak = max(int(np.abs(item.samples).max(initial=1)), 1)
        level = rng.uniform(6000, 16000) / peak
        sounds += [(item.samples * level).astype(np.int16), gap]
    sound = np.concatenate(sounds)
    if len(sound) > LONGEST * RATE:
        return items[0]
    return Item(sound, " ".join(item.text for item in items))


def _around(aligned: Aligned, index: int, rng: Generator) -> Item:
    """A wanted word alone or with up to two neighbours on each side."""
    before, after = rng.integers(0, 3, 2) if rng.random() < 0.5 else (0, 0)
    first = max(index - int(before), 0)
    return _item(excerpt(aligned, first, min(index + 1 + int(after), len(aligned.words))).clip)


def _item(clip: TrainingClip) -> Item:
    return Item(clip.samples, clip.text)


def _whole(clips: Sequence[TrainingClip]) -> Source:
    return lambda rng: _item(_pick(clips, rng))


def _name(clip: TrainingClip) -> str:
    if clip.kind != "word":
        return clip.kind
    if clip.text == "stop":
        return "human stop"
    if clip.text in CLOSE:
        return "human close"
    return "human rare" if clip.text in RARE else "human word"


def _pick(choices: Sequence[T], rng: Generator) -> T:
    return choices[int(rng.integers(len(choices)))]

# SPDX-License-Identifier: BSD-3-Clause
"""Embeddings to train the spotter on, computed once and kept in a cache."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from random import Random

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from voice_assist.errors import ModelError
from voice_assist.spotter.features import STEP, Embeddings, seconds
from voice_assist.training.array_file import write_arrays
from voice_assist.training.cache_key import keyed
from voice_assist.training.data import texts, voices
from voice_assist.training.data.human import (
    ManifestRow,
    load_speech,
    load_surroundings,
    read_manifest,
    speech_rows,
    stamped,
)
from voice_assist.training.data.noise import Surroundings
from voice_assist.training.data.synthesis import TrainingClip, cast_voice, synthesise
from voice_assist.training.spotter.embed import LongEmbedder
from voice_assist.training.spotter.streams import (
    WORD,
    LabelledStream,
    Style,
    noise_streams,
    streams,
)
from voice_assist.types import RATE

LOG = logging.getLogger("spotter")
NEGATIVE, IGNORED = -1, -2
_WORDS = Style(again=0.1, talker=0.2)
_FLUENT = Style(speed=(0.9, 1.1), noise=0.5, talker=0.1)
_EARLY, _LATE, _AFTER = 0.04, 0.36, 0.9  # [s] around the end of a word
_SHORT, _TALK = 2.5, 1.5  # [s] that single words are below, and that talk is above

# Said like the word by the synthetic voices, and not it.
NEAR = texts.phrases("""
top|shop|step|up|start|stomp|stuff|stock|stopped|stopping|stops|strap|chop|slop|drop|hop|pop
crop|star|store|stand|stay|still|stool|scope|sob|spot|stab|swap|laptop|tap|tough|stub|stump|type
stoop|steep|stamp|staff|stiff|storm|stone|stack|stuck|stalk|sock|soap|soup|sup|sap|op|on top|okay
step up|hey shop|the shop|add up|set up|cut|but|got|not|what|hot|god|job|top it up|one step|snow
go|no|yes|on|off|down|left|right|house|dog|bob|boy|hadouken|jarvis|computer|amelia|snowboy|athena
sport|spat|stopper|post|past|most|test|cost|lost|hoped|pope|rope|hope|cope|tape|tip|tub
""")


@dataclass(frozen=True, eq=False)
class Steps:
    """Embeddings of one kind of stream, one row per step."""

    embeddings: NDArray[np.float16]  # (n, WIDTH)
    labels: NDArray[np.int32]  # (n,): NEGATIVE, IGNORED, or the number of the word that just ended
    begins: NDArray[np.int64]  # rows at which a stream begins


@dataclass(frozen=True)
class SpotterAmounts:
    """How much of each kind to embed."""

    rounds: int = 20  # copies of every human WORD
    synthetic: int = 2500  # prompts of WORD
    near: int = 4500  # prompts of NEAR and other texts
    noise: int = 90  # streams
    thin: int = 2  # of the sentences, one in so many
    recorded: int = 1  # of the recordings of sentences, one in so many is read at all


@dataclass(frozen=True, eq=False)
class SpotterMaterial:
    """What streams are made of."""

    words: list[TrainingClip]  # people, one or two words
    stops: list[TrainingClip]  # people saying WORD
    sentences: list[TrainingClip]  # people, without WORD
    synthetic: list[TrainingClip]
    near: list[TrainingClip]
    around: Surroundings


def training_rows(speech: Path, amounts: SpotterAmounts) -> list[ManifestRow]:
    """Rows of the manifest to train on, before any of their sound is read.

    Raises:
        ManifestError: The manifest cannot be read.
        ModelError: Too few people are in it, or none.
    """
    rows = _thinned(read_manifest(speech), amounts.recorded)
    said = [
        (_role(texts.normalise_text(row.transcript), row.seconds), row.seconds)
        for row in speech_rows(rows, "train")
    ]
    counts = {
        f"recordings of {WORD!r} alone": sum(role == WORD for role, _ in said),
        "of one or two other words": sum(role == "words" for role, _ in said),
        f"of talk over {_TALK:g} s": sum(role == "talk" and time > _TALK for role, time in said),
    }
    if not all(counts.values()):
        held = ", ".join(f"{count} {what}" for what, count in counts.items())
        needed = 'a spotter needs at least 1 of each (models/README.md, "Data and licences")'
        raise ModelError(f"{speech}, split train: {held}; {needed}")
    return rows


def _role(text: str, seconds: float) -> str:
    """Of a person's clip: WORD, "words" or "talk"; empty, and of no use, where more is said."""
    words = text.split()
    if WORD in words:
        return WORD if text == WORD else ""
    return "words" if len(words) <= 2 and seconds < _SHORT else "talk"


def load_material(speech: Path, cache: Path, seed: int, amounts: SpotterAmounts) -> SpotterMaterial:
    """Read the recordings of split `train`, and speak the synthetic prompts.

    Raises:
        ManifestError: As `training_rows`.
        ModelError: As `training_rows`, or an engine of synthesis is missing.
    """
    rows = training_rows(speech, amounts)
    human = load_speech(rows, "train", cache / "recordings")
    stops, words, sentences = (
        [clip for clip in human if _role(clip.text, len(clip.samples) / RATE) == role]
        for role in (WORD, "words", "talk")
    )
    rng = Random(seed)
    spoken = [WORD] * amounts.synthetic
    spans = [t for t in texts.TALK + texts.COMMANDS if WORD not in t.split()]
    spoken += [rng.choice(NEAR if rng.random() < 0.75 else spans) for _ in range(amounts.near)]
    variants, _ = voices.espeak_variants()
    prompts = [cast_voice(text, variants, rng) for text in spoken]
    prompts.sort(key=voices.by_voice)
    clips = synthesise(prompts, cache / "synthetic", workers=1)
    talkers = [c.samples for c in sentences if len(c.samples) > _TALK * RATE]
    return SpotterMaterial(
        words=words,
        stops=stops,
        sentences=sentences,
        synthetic=[clip for clip in clips if clip.text == WORD],
        near=[clip for clip in clips if clip.text != WORD],
        around=load_surroundings(rows, np.random.default_rng(seed), talkers),
    )


def _thinned(rows: list[ManifestRow], one_in: int) -> list[ManifestRow]:
    """All single words, noises and rooms, and one in so many sentences."""
    is_sentence = [row.kind == "speech" and len(row.transcript.split()) > 2 for row in rows]
    number = np.cumsum(is_sentence)
    return [
        r
        for r, long, n in zip(rows, is_sentence, number, strict=True)
        if not long or n % one_in == 0
    ]


def load_steps(speech: Path, cache: Path, seed: int, amounts: SpotterAmounts) -> dict[str, Steps]:
    """Embed all kinds of streams, or read what the cache holds of them.

    Args:
        speech: Folder with manifest.csv.
        cache: Folder for all that is computed.
        seed: Of all chance.
        amounts: How much of each kind.

    Raises:
        ManifestError: As `training_rows`.
        ModelError: As `load_material`.
    """
    rows = training_rows(speech, amounts)
    heard = stamped([row for row in rows if row.split == "train"])
    said = (NEAR, texts.TALK, texts.COMMANDS)
    paths = {kind: keyed(cache / f"{kind}.npz", seed, amounts, heard, said) for kind in _KINDS}
    if not all(path.exists() for path in paths.values()):
        material = load_material(speech, cache, seed, amounts)
        for number, (kind, path) in enumerate(paths.items()):
            if not path.exists():
                rng = np.random.default_rng([seed, number])
                _compute(_KINDS[kind](material, amounts, rng), path)
    found = {kind: _read(path) for kind, path in paths.items()}
    for kind, steps in found.items():
        LOG.info("%s: %.2f h", kind, len(steps.labels) * STEP / RATE / 3600)
    return found


def label(stream: LabelledStream, count: int, first: int) -> NDArray[np.int32]:
    """Labels of the steps of a stream.

    Args:
        stream: With the times of its words.
        count: Steps.
        first: Number of its first word; the others follow.
    """
    times = np.array([seconds(step) for step in range(count)])
    labels = np.full(count, NEGATIVE, np.int32)
    for begin, end in stream.words:
        labels[(times > begin) & (times <= end + _AFTER)] = IGNORED
    for number, (_, end) in enumerate(stream.words, first):
        labels[(times >= end - _EARLY) & (times <= end + _LATE)] = number
    return labels


def _read(path: Path) -> Steps:
    with np.load(path) as stored:
        return Steps(stored["embeddings"], stored["labels"], stored["begins"])


def _human(
    material: SpotterMaterial, amounts: SpotterAmounts, rng: Generator
) -> Iterator[LabelledStream]:
    """Every WORD many times among single words of people, and those often."""
    for _ in range(amounts.rounds):
        clips = [*material.stops]
        count = min(2 * len(clips), len(material.words))
        picked = rng.choice(len(material.words), count, replace=False)
        clips += [material.words[i] for i in picked]
        order = rng.permutation(len(clips))
        yield from streams([clips[i] for i in order], material.around, _WORDS, rng)


def _synthetic(
    material: SpotterMaterial, amounts: SpotterAmounts, rng: Generator
) -> Iterator[LabelledStream]:
    clips = material.synthetic + material.near
    order = rng.permutation(len(clips))
    yield from streams([clips[i] for i in order], material.around, _WORDS, rng)


def _sentences(
    material: SpotterMaterial, amounts: SpotterAmounts, rng: Generator
) -> Iterator[LabelledStream]:
    yield from streams(material.sentences[:: amounts.thin], material.around, _FLUENT, rng)


def _noise(
    material: SpotterMaterial, amounts: SpotterAmounts, rng: Generator
) -> Iterator[LabelledStream]:
    yield from noise_streams(material.around, amounts.noise, rng)


_KINDS: dict[
    str, Callable[[SpotterMaterial, SpotterAmounts, Generator], Iterator[LabelledStream]]
] = {
    "human": _human,
    "synthetic": _synthetic,
    "sentences": _sentences,
    "noise": _noise,
}


def _compute(made: Iterator[LabelledStream], path: Path) -> None:
    embedder, began = LongEmbedder(), time.monotonic()
    rows: list[Embeddings] = []
    labels: list[NDArray[np.int32]] = []
    begins, total, words = [], 0, 0
    for stream in made:
        found = embedder(stream.sound)
        rows.append(found.astype(np.float16))
        labels.append(label(stream, len(found), words))
        begins.append(total)
        total, words = total + len(found), words + len(stream.words)
    embeddings, all_labels = np.concatenate(rows), np.concatenate(labels)
    write_arrays(path, embeddings=embeddings, labels=all_labels, begins=np.array(begins))
    LOG.info("%s: %d steps, %d words, %.0f s", path.name, total, words, time.monotonic() - began)

# SPDX-License-Identifier: BSD-3-Clause
"""Train the verifier of phrases: python -m voice_assist.training.verifier.train_verifier.

Where Kokoro's packages are missing, its voices are left out.
"""

from __future__ import annotations

import argparse
import json
import logging
import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from zlib import crc32

import numpy as np
import torch
from numpy.typing import NDArray
from torch.nn.functional import binary_cross_entropy_with_logits
from torch.nn.utils import parameters_to_vector

from typed_config import check_writable, count_option, run_command
from voice_assist.audio.espeak import Int16
from voice_assist.errors import ModelError, VoiceError
from voice_assist.recognizer.checkpoint import EMBEDDED_PATH, read_checkpoint
from voice_assist.recognizer.embedded import restore
from voice_assist.recognizer.hybrid import WhisperCtc
from voice_assist.recognizer.verification import BLOCKS, PATH, write_verifier
from voice_assist.training.cache_key import keyed
from voice_assist.training.data import kokoro
from voice_assist.training.data.human import (
    ManifestRow,
    load_speech,
    load_surroundings,
    read_manifest,
    stamped,
    training_sentences,
)
from voice_assist.training.data.neural_voices import plan_neural
from voice_assist.training.data.synthesis import speak_all
from voice_assist.training.data.texts import TALK
from voice_assist.training.data.voices import by_voice
from voice_assist.training.fit.train_recognizer import REPOSITORY, lower_parts
from voice_assist.training.options import speech_option
from voice_assist.training.verifier import examples
from voice_assist.training.verifier.examples import Examples, Seen

LOG = logging.getLogger("verifier")
LOST = 0.005  # share of a phrase's clips, each in a voice that is left out, with odds below 0
TAKES = {True: 1, False: 2}  # times that a clip is varied: one of a command, one of another word
_WEIGHT = 0.3  # of the squared weights in the loss
_FOLDS = 5  # of the voices, left out one after the other


def parse(arguments: list[str] | None = None) -> argparse.Namespace:
    """Options of a run; the shipped file was made with an --aligner (VERIFIER.md)."""
    parser = argparse.ArgumentParser(description=__doc__)
    add = parser.add_argument
    add("--speech", type=speech_option, default=REPOSITORY.parent / "shared" / "speech")
    add("--cache", type=Path, default=REPOSITORY / ".cache" / "training")
    add("--packages", type=Path, default=REPOSITORY / ".cache" / "training" / "openai")
    add("--recogniser", type=Path, default=EMBEDDED_PATH, help="that it belongs to")
    add("--aligner", type=Path, help="another recogniser with the same lower blocks, to align by")
    add("--out", type=Path, default=PATH)
    add("--seed", type=int, default=1)
    add("--threads", type=count_option, default=1)
    return parser.parse_args(arguments)


def main() -> None:
    """Run the command line; ends with 2 where what was asked cannot be done."""
    if status := run_command(lambda: _run(parse()), "train_verifier", (VoiceError,), failed=2):
        sys.exit(status)


def _run(options: argparse.Namespace) -> None:
    """Train, log what the development voices say, and leave the file in place."""
    logging.basicConfig(level=logging.INFO, format="%(asctime)s %(message)s")
    check_writable(options.out)
    torch.set_num_threads(options.threads)
    checkpoint = read_checkpoint(options.recogniser)
    aligner = read_checkpoint(options.aligner) if options.aligner else checkpoint
    model = restore(aligner).eval()
    if options.aligner and not sees_the_same(model, restore(checkpoint)):
        raise ModelError(f"{options.aligner} and {options.recogniser} differ in their lower blocks")
    rows = read_manifest(options.speech)
    said = [*_espeak(options), *_people(rows, options), *_kokoro(rows, options)]
    around = stamped([row for row in rows if row.split == "train" and row.kind in ("noise", "rir")])
    made_of = (aligner.sha256, options.seed, said, around)
    kept = keyed(options.cache / "verifier" / "examples.npz", *made_of)
    if not kept.exists():
        examples.save(list(_seen(model, said, rows, options.seed)), kept)
    weights = {}
    for phrase, some in examples.load(kept).items():
        weights[phrase], figures = train(some)
        LOG.info("%s: %s", phrase, json.dumps(figures))
    write_verifier(weights, checkpoint.sha256, options.out)


def sees_the_same(one: WhisperCtc, other: WhisperCtc) -> bool:
    """Whether the states that the verifier reads are the same in two recognisers."""
    weights, others = (
        parameters_to_vector([w for part in lower_parts(model, BLOCKS) for w in part.parameters()])
        for model in (one, other)
    )
    return torch.equal(weights, others)


def train(some: Examples) -> tuple[NDArray[np.float32], dict[str, float]]:
    """Weights of a phrase, its bias last, and what they do in voices that were left out.

    All voices train the weights. The bias makes the odds 0 where LOST of the clips of the phrase
    lie below, each judged by a classifier that never heard its voice.
    """
    folds = np.array([fold_of(voice) for voice in some.voices])
    odds = np.zeros(len(folds))
    for fold in range(_FOLDS):
        is_out = folds == fold
        odds[is_out] = _fit(some.seen[~is_out], some.is_said[~is_out])(some.seen[is_out])
    said, other = odds[some.is_said], odds[~some.is_said]
    least = float(np.quantile(said, LOST))
    figures = {
        "said": len(said),
        "other": len(other),
        "least": least,
        "others taken": float((other >= least).mean()),
        "area": float((said[:, None] > other).mean()),
    }
    judge = _fit(some.seen, some.is_said)
    zero = judge(np.zeros((1, some.seen.shape[1]), np.float32))[0]
    weights = judge(np.eye(some.seen.shape[1], dtype=np.float32)) - zero
    return np.append(weights, zero - least).astype(np.float32), figures


def fold_of(voice: str) -> int:
    """The fold in which a voice is left out, the same in all of its accents and engines.

    Args:
        voice: Such as "kokoro:af_bella", or with an accent "espeak:en-us+m3".
    """
    return crc32(voice.rpartition("+")[2].encode()) % _FOLDS


def _fit(
    seen: NDArray[np.float32], is_said: NDArray[np.bool_]
) -> Callable[[NDArray[np.float32]], NDArray[np.float64]]:
    """Logistic regression with both classes in balance; gives log-odds of shape (n,)."""
    centre, spread = seen.mean(0), seen.std(0) + 1e-3
    x = torch.from_numpy((seen - centre) / spread)
    y = torch.from_numpy(is_said.astype(np.float32))
    share = y.mean()
    balance = torch.where(y > 0.5, 0.5 / share, 0.5 / (1.0 - share))
    weights = torch.zeros(x.shape[1], requires_grad=True)
    bias = torch.zeros(1, requires_grad=True)
    optimiser = torch.optim.LBFGS([weights, bias], max_iter=200, line_search_fn="strong_wolfe")

    def loss() -> torch.Tensor:
        optimiser.zero_grad()
        cross = binary_cross_entropy_with_logits(x @ weights + bias, y, reduction="none")
        value = (balance * cross).mean() + _WEIGHT * weights.square().sum()
        value.backward()
        return value

    optimiser.step(loss)
    w = (weights.detach().numpy() / spread).astype(np.float64)
    b = float(bias.detach()) - float(w @ centre)
    return lambda given: given @ w + b


_Clip = tuple[Int16, str, str]  # sound, the command that it says, its voice


def _seen(
    model: WhisperCtc, said: Sequence[_Clip], rows: Sequence[ManifestRow], seed: int
) -> Iterator[Seen]:
    """What the verifier sees of each clip, varied."""
    rng = np.random.default_rng(seed)
    around = load_surroundings(rows, rng)
    for number, (sound, command, voice) in enumerate(said):
        for _ in range(TAKES[bool(command)]):
            varied = examples.varied(sound, around, rng)
            for phrase, seen in examples.phrase_segments(model, varied, command):
                yield Seen(phrase, seen, bool(command), voice)
        if number % 500 == 0:
            LOG.info("%d clips", number)


def _espeak(options: argparse.Namespace) -> Iterator[_Clip]:
    planned = {one.prompt: one.command for one in examples.plan(options.seed)}
    prompts = sorted(planned, key=by_voice)
    for prompt, sound in speak_all(prompts, options.cache / "verifier", options.threads):
        yield sound, planned[prompt], f"{prompt.engine}:{prompt.voice}"


def _people(rows: Sequence[ManifestRow], options: argparse.Namespace) -> Iterator[_Clip]:
    """Single words of people, none of them of a command."""
    of_commands = {word for phrase in examples.PHRASES for word in phrase.split()}
    for clip in load_speech(rows, "train", options.cache / "recordings"):
        if clip.kind == "word" and of_commands.isdisjoint(clip.text.split()):
            yield clip.samples, "", f"human:{clip.speaker}"


def _kokoro(rows: Sequence[ManifestRow], options: argparse.Namespace) -> Iterator[_Clip]:
    """Commands, in accents, too, and words of other languages."""
    plan = plan_neural([*training_sentences(rows), *TALK])
    try:
        said = kokoro.speak(plan, options.packages, options.cache / "neural")
    except ModelError as error:
        LOG.info("Kokoro left out: %s", error)
        return
    for one, sound in said:
        if one.text in examples.PHRASES or one.kind == "foreign":
            yield sound, "" if one.kind == "foreign" else one.text, f"kokoro:{one.voice}"


if __name__ == "__main__":
    main()

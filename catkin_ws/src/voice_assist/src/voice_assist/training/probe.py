# SPDX-License-Identifier: BSD-3-Clause
"""Can the network tell synthesis from people? python -m voice_assist.training.probe.

A linear classifier looks at the mean encoder state of short words, the same words from
both, and is tested on voices and speakers that it was not fitted to. The less it can
tell, the more of what is learnt from synthesis holds for people.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import torch
from numpy.typing import NDArray
from scipy.stats import rankdata
from torch import Tensor
from torch.nn import functional

from voice_assist.recognizer.checkpoint import find_checkpoint, read_checkpoint
from voice_assist.recognizer.embedded import restore
from voice_assist.recognizer.hybrid import HybridWhisper
from voice_assist.recognizer.mel import log_mel
from voice_assist.training.data import voices
from voice_assist.training.data.augment import Strength, add_background, colour, place
from voice_assist.training.data.noise import build_rooms
from voice_assist.training.data.synthesis import Clip, synthesise
from voice_assist.training.data.voices import Int16, Prompt
from voice_assist.training.figures import held_out_corpus, parse
from voice_assist.types import RATE

WORDS = ("yes", "no", "up", "down", "left", "right", "on", "off", "go", "stop")
FOLDS = 5
LENGTH = RATE  # samples of each clip
PENALTY = 1e-2  # on the squared weights of standardised features
CONDITIONS = {
    "as recorded": None,
    "changed as in training": Strength(),
    "changed, noise at 0 to 6 dB": Strength(noise=1.0, snr=(0.0, 6.0)),
}

Floats = NDArray[np.float32]


def main() -> None:
    """Print how well synthesis and people are told apart, in quiet and in noise."""
    options = parse(__doc__)
    model = restore(read_checkpoint(find_checkpoint(options.model))).eval()
    corpus = held_out_corpus(options.speech, options.cache, options.seed)
    spoken = synthesise(plan_words(options.seed), options.cache / "probe")
    people = [clip for clip in corpus.people if clip.text in WORDS]
    clips = evenly(spoken, people, np.random.default_rng(options.seed))
    is_human = np.array([clip.kind == "word" for clip in clips])
    groups = [clip.speaker for clip in clips]
    print(f"{is_human.sum()} clips of people, {(~is_human).sum()} of synthesis")
    around = replace(corpus.around, rooms=build_rooms([], np.random.default_rng(options.seed)))
    batch = torch.from_numpy(np.stack([centred(clip.samples) for clip in clips]))
    for name, how in CONDITIONS.items():
        rng = np.random.default_rng(options.seed)
        heard = (
            batch
            if how is None
            else add_background(colour(batch, around, how, rng), around, how, rng)
        )
        for what, features in pooled(model, heard).items():
            area = separability(features, is_human, groups)
            print(f"{name}, {what}: area under the curve {area:.3f}", flush=True)


def plan_words(seed: int) -> list[Prompt]:
    """The words in the espeak, flite and festival voices that training never hears."""
    rng = np.random.default_rng(seed)
    _, variants = voices.espeak_variants()
    cast: list[tuple[voices.Engine, str]] = []
    for variant in variants:
        for accent in (voices.HELD_OUT_ACCENT, str(rng.choice(voices.ACCENTS))):
            cast.append(("espeak", f"{accent}+{variant}"))
    cast += [("flite", name) for name in voices.HELD_OUT_FLITE]
    cast += [("festival", name) for name in voices.HELD_OUT_FESTIVAL]
    return [
        Prompt(word, engine, voice, float(rng.uniform(0.85, 1.2)), float(rng.uniform(0.35, 0.65)))
        for engine, voice in sorted(cast)
        for word in WORDS
    ]


def evenly(one: Sequence[Clip], other: Sequence[Clip], rng: np.random.Generator) -> list[Clip]:
    """As many clips of each word from both, so that the words tell nothing."""
    kept: list[Clip] = []
    for word in WORDS:
        sets = [[clip for clip in clips if clip.text == word] for clips in (one, other)]
        count = min(map(len, sets))
        kept += [found[i] for found in sets for i in rng.permutation(len(found))[:count]]
    return kept


def centred(samples: Int16) -> Floats:
    """LENGTH samples with the clip in their middle, at one peak level."""
    kept = samples[:LENGTH].astype(np.float32)
    level = np.float32(0.3 / max(float(np.abs(kept).max()), 1.0))
    return place(kept * level, LENGTH, (LENGTH - len(kept)) // 2)


@torch.inference_mode()
def pooled(model: HybridWhisper, batch: Tensor) -> dict[str, Floats]:
    """Means over time of the spectrogram and of the encoder's states, (clips, d) each."""
    mels = [log_mel(part) for part in batch.split(32)]
    states = [model.encode(mel).mean(dim=1) for mel in mels]
    spectra = [mel.mean(dim=2) for mel in mels]
    return {"spectrogram": torch.cat(spectra).numpy(), "states": torch.cat(states).numpy()}


def separability(features: Floats, labels: NDArray[np.bool_], groups: Sequence[str]) -> float:
    """Area under the ROC curve of a logistic regression, on groups it was not fitted to.

    Args:
        features: Shape (n, d).
        labels: Shape (n,).
        groups: Speaker or voice of each clip, n of them; none is in two folds.

    Returns:
        0.5 for no difference, 1 for a perfect one.
    """
    names, index = np.unique(groups, return_inverse=True)
    fold = np.random.default_rng(0).permutation(len(names))[index] % FOLDS
    scores = np.zeros(len(labels))
    for number in range(FOLDS):
        is_tested = fold == number
        centre, scale, weights, offset = _fit(features[~is_tested], labels[~is_tested])
        scores[is_tested] = (features[is_tested] - centre) / scale @ weights + offset
    ranks = rankdata(scores)[labels]
    ones, zeros = int(labels.sum()), int((~labels).sum())
    return float((ranks.sum() - ones * (ones + 1) / 2) / (ones * zeros))


def _fit(features: Floats, labels: NDArray[np.bool_]) -> tuple[Floats, Floats, Floats, float]:
    """Centre, scale, weights and offset of a logistic regression with a penalty."""
    centre, scale = features.mean(axis=0), features.std(axis=0) + np.float32(1e-6)
    inputs = torch.from_numpy((features - centre) / scale)
    wanted = torch.from_numpy(labels.astype(np.float32))
    weights = torch.zeros(features.shape[1], requires_grad=True)
    offset = torch.zeros(1, requires_grad=True)
    optimiser = torch.optim.LBFGS([weights, offset], max_iter=100, line_search_fn="strong_wolfe")

    def loss() -> Tensor:
        optimiser.zero_grad()
        error = functional.binary_cross_entropy_with_logits(inputs @ weights + offset, wanted)
        total = error + PENALTY * weights.square().sum()
        total.backward()
        return total

    optimiser.step(loss)
    return centre, scale, weights.detach().numpy(), float(offset.detach())


if __name__ == "__main__":
    main()

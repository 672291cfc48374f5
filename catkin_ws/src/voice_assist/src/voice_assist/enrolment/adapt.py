# SPDX-License-Identifier: BSD-3-Clause
"""Adaptation: the upper layers of the recogniser learn a voice on stored outputs of the lower.

Sound goes through the lower encoder blocks once; only what lies above is trained, so a step costs
a fraction of one of `training.fit`. Examples of other voices are mixed into every step, so that
nothing that the base could is forgotten.
"""

from __future__ import annotations

import copy
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import torch
from numpy.random import Generator
from torch import Tensor

from voice_assist.config.enrolment import AdaptConfig
from voice_assist.enrolment.examples import Example
from voice_assist.recognizer.hybrid import WhisperCtc, encode_lower, encode_upper
from voice_assist.recognizer.mel import log_mel
from voice_assist.recognizer.vocabulary import encode
from voice_assist.training.data.batches import teacher_tensors
from voice_assist.training.fit.objective import combined

_CLIPPED = 1.0  # norm of a step's gradient
_LENGTHS_OF_OTHERS = 0.2  # of the steps, so that talk, longer than any command, is not forgotten


@dataclass(frozen=True, eq=False)
class Adapted:
    """What adaptation came to."""

    state: dict[str, Tensor]  # the tensors that were trained, by their name in WhisperCtc
    seconds: float  # [s] of CPU time


@dataclass(frozen=True, eq=False)
class _Stored:
    """An example below the trained layers."""

    hidden: Tensor  # (time, d)
    text: list[int]


def trained_names(model: WhisperCtc, frozen_blocks: int) -> list[str]:
    """Names of the parameters that adaptation changes: all above the frozen encoder blocks.

    Token and position embeddings stay; a few takes say nothing about letters they do not hold.
    """
    blocks = range(frozen_blocks, model.dims.n_audio_layer)
    above = [f"whisper.encoder.blocks.{index}." for index in blocks]
    above += ["whisper.encoder.ln_post.", "whisper.decoder.blocks.", "whisper.decoder.ln.", "ctc."]
    return [name for name, _ in model.named_parameters() if name.startswith(tuple(above))]


def adapt(
    model: WhisperCtc, own: Sequence[Example], others: Sequence[Example], config: AdaptConfig
) -> Adapted:
    """Learn a voice.

    Args:
        model: The base; it is not changed.
        own: What the person said, varied. Each a multiple of GRID long.
        others: What must stay as it is, varied.
        config: How long and how fast.
    """
    began = time.process_time()
    learner = copy.deepcopy(model)
    stored = [_store(learner, some, config.frozen_blocks) for some in (own, others)]
    names = trained_names(learner, config.frozen_blocks)
    trained = [learner.get_parameter(name) for name in names]
    for parameter in learner.parameters():
        parameter.requires_grad_(False)
    for parameter in trained:
        parameter.requires_grad_(True)
    optimiser = torch.optim.Adam(trained, lr=config.rate, betas=(0.9, 0.98))
    batches = _batches(stored[0], stored[1], config, np.random.default_rng(config.seed))
    for step, batch in zip(range(config.steps), batches, strict=False):
        for group in optimiser.param_groups:
            group["lr"] = config.rate * min((step + 1) / 10, 1.0 - step / config.steps)
        loss = _loss(learner, batch, config.frozen_blocks)
        optimiser.zero_grad()
        loss.backward()
        torch.nn.utils.clip_grad_norm_(trained, _CLIPPED)
        optimiser.step()
    state = {name: learner.get_parameter(name).detach().clone() for name in names}
    return Adapted(state, time.process_time() - began)


def _store(model: WhisperCtc, examples: Sequence[Example], blocks: int) -> list[_Stored]:
    with torch.no_grad():
        return [
            _Stored(_below(model, example, blocks), encode(example.text)) for example in examples
        ]


def _below(model: WhisperCtc, example: Example, blocks: int) -> Tensor:
    mel = log_mel(torch.from_numpy(np.array(example.samples))[None])
    return encode_lower(model.whisper.encoder, mel, blocks)[0]


def _batches(
    own: Sequence[_Stored], others: Sequence[_Stored], config: AdaptConfig, rng: Generator
) -> Iterator[list[_Stored]]:
    """Endless batches, each of one length; most of a length that the person's examples have."""
    both = [np.array([len(one.hidden) for one in some]) for some in (own, others)]
    while True:
        lengths = both[1] if len(others) and rng.random() < _LENGTHS_OF_OTHERS else both[0]
        length = int(rng.choice(lengths))
        mine = [one for one in own if len(one.hidden) == length]
        theirs = [one for one in others if len(one.hidden) == length]
        count = round(config.own_share * config.batch) if theirs else config.batch
        count = count if mine else 0
        batch = [mine[i] for i in rng.integers(len(mine), size=count)] if mine else []
        if theirs:
            batch += [theirs[i] for i in rng.integers(len(theirs), size=config.batch - count)]
        yield batch


def _loss(model: WhisperCtc, batch: Sequence[_Stored], blocks: int) -> Tensor:
    """The loss of training, from the stored states up."""
    hidden = torch.stack([one.hidden for one in batch])
    states = encode_upper(model.whisper.encoder, hidden, blocks)
    texts = [one.text for one in batch]
    tokens, targets = teacher_tensors(texts)
    logits = model.logits(tokens, states)
    return combined(model.ctc_logprobs(states), logits, targets, texts).total

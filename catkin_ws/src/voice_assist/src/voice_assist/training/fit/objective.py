# SPDX-License-Identifier: BSD-3-Clause
"""What training minimises: decoder cross-entropy and CTC, jointly."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor
from torch.nn import functional

from voice_assist.recognizer.hybrid import WhisperCtc
from voice_assist.recognizer.vocabulary import BLANK
from voice_assist.training.data.batches import IGNORED, Batch
from voice_assist.training.precision import cheap_numbers

CTC_SHARE = 0.4
SMOOTHING = 0.05


@dataclass(frozen=True)
class JointLoss:
    """Both parts and their weighted sum, each per token."""

    total: Tensor
    ctc: float
    decoder: float


def joint_loss(model: WhisperCtc, batch: Batch) -> JointLoss:
    """Hybrid CTC/attention loss (Watanabe et al. 2017), in bfloat16 where safe."""
    with cheap_numbers(batch.mel.device.type):
        states = model.encode(batch.mel)
        logprobs = model.ctc_logprobs(states)
        logits = model.logits(batch.tokens, states)
    ctc = ctc_loss(logprobs, batch.texts)
    decoder = functional.cross_entropy(
        logits.flatten(0, 1),
        batch.targets.flatten(),
        ignore_index=IGNORED,
        label_smoothing=SMOOTHING,
    )
    total = CTC_SHARE * ctc + (1 - CTC_SHARE) * decoder
    return JointLoss(total, float(ctc.detach()), float(decoder.detach()))


def ctc_loss(logprobs: Tensor, texts: list[list[int]]) -> Tensor:
    """CTC loss per character.

    Args:
        logprobs: Shape (batch, time, BLANK + 1).
        texts: Character ids of each item; empty for none.
    """
    ids = [index for text in texts for index in text]
    joined = torch.tensor(ids, dtype=torch.long, device=logprobs.device)
    lengths = torch.tensor([len(text) for text in texts])
    times = torch.full((len(texts),), logprobs.shape[1])
    loss = functional.ctc_loss(
        logprobs.transpose(0, 1),
        joined,
        times,
        lengths,
        blank=BLANK,
        reduction="sum",
        zero_infinity=True,
    )
    return loss / (lengths.sum() + len(texts))

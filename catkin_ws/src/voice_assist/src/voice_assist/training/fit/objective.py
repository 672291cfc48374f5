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

_CTC_SHARE = 0.4
_SMOOTHING = 0.05


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
    return combined(logprobs, logits, batch.targets, batch.texts)


def combined(
    logprobs: Tensor, logits: Tensor, targets: Tensor, texts: list[list[int]]
) -> JointLoss:
    """The loss of what both heads give.

    Args:
        logprobs: Of the CTC head. Shape (batch, time, BLANK + 1).
        logits: Of the decoder. Shape (batch, length, ids).
        targets: Wanted of the decoder. Shape (batch, length).
        texts: Character ids of each item.
    """
    ctc = ctc_loss(logprobs, texts)
    decoder = functional.cross_entropy(
        logits.flatten(0, 1),
        targets.flatten(),
        ignore_index=IGNORED,
        label_smoothing=_SMOOTHING,
    )
    total = _CTC_SHARE * ctc + (1 - _CTC_SHARE) * decoder
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

# SPDX-License-Identifier: BSD-3-Clause
"""Log-likelihoods of whole texts, several in one pass through the decoder."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import torch
from torch import Tensor
from torch.nn import functional

from voice_assist.recognizer.hybrid import WhisperCtc
from voice_assist.recognizer.vocabulary import BLANK, END, PROMPT, encode


def decoder_likelihoods(model: WhisperCtc, states: Tensor, texts: Sequence[str]) -> Tensor:
    """Log-probability of each text and its end by the decoder.

    Args:
        model: Whose decoder to ask.
        states: Encoder states of one sound, on the model's device. Shape (1, time, d).
        texts: Normalised; empty for silence.

    Returns:
        Shape (len(texts),), on the CPU.
    """
    ids = [encode(text) for text in texts]
    width = max(map(len, ids)) + 1
    wanted = torch.full((len(ids), width), -1)
    for row, line in enumerate(ids):
        wanted[row, : len(line) + 1] = torch.tensor([*line, END])
    wanted = wanted.to(states.device)
    prompt = torch.tensor([PROMPT], device=states.device).expand(len(ids), -1)
    fed = torch.cat([prompt, wanted[:, :-1].clamp(min=0)], dim=1)
    memory = {k: v.expand(len(ids), *v.shape[1:]) for k, v in model.remember(states).items()}
    logits = model.logits(fed, states, memory)
    logprobs = logits[:, len(PROMPT) - 1 :].log_softmax(-1)
    chosen = logprobs.gather(-1, wanted.clamp(min=0).unsqueeze(-1)).squeeze(-1)
    return (chosen * (wanted >= 0)).sum(-1).cpu()


def ctc_likelihoods(logprobs: Tensor, texts: Sequence[str]) -> Tensor:
    """Log-probability of each text over all alignments (Graves et al. 2006).

    Args:
        logprobs: CTC head's output for one sound. Shape (time, BLANK + 1).
        texts: Normalised; empty for silence.

    Returns:
        Shape (len(texts),); -inf where a text is too long for the sound.
    """
    ids = [encode(text) for text in texts]
    loss = functional.ctc_loss(
        logprobs.unsqueeze(1).expand(-1, len(ids), -1),
        torch.tensor([index for line in ids for index in line], dtype=torch.long),
        torch.full((len(ids),), len(logprobs)),
        torch.tensor([len(line) for line in ids]),
        blank=BLANK,
        reduction="none",
    )
    return -loss


def ratios(likelihoods: Mapping[str, float], phrases: Sequence[str]) -> dict[str, float]:
    """Each phrase against the best of all other texts.

    Args:
        likelihoods: Log-likelihood of the phrases and of every rival text.
        phrases: Some of the texts, two or more texts in all.
    """
    return {
        phrase: likelihoods[phrase]
        - max(value for text, value in likelihoods.items() if text != phrase)
        for phrase in phrases
    }

# SPDX-License-Identifier: BSD-3-Clause
"""Where training starts: from nothing, or from a Whisper model's weights."""

from __future__ import annotations

from dataclasses import replace

import torch
from whisper.model import ModelDimensions

from voice_assist.recognizer.checkpoint import find_checkpoint, read_checkpoint
from voice_assist.recognizer.hybrid import HybridWhisper
from voice_assist.recognizer.vocabulary import WHISPER_IDS

EMBEDDING = "decoder.token_embedding.weight"
POSITIONS = {"encoder.positional_embedding": 512, "decoder.positional_embedding": 192}

SMALL = ModelDimensions(
    n_mels=80,
    n_audio_ctx=POSITIONS["encoder.positional_embedding"],  # 10.24 s
    n_audio_state=192,
    n_audio_head=3,
    n_audio_layer=5,
    n_vocab=51864,
    n_text_ctx=POSITIONS["decoder.positional_embedding"],
    n_text_state=192,
    n_text_head=3,
    n_text_layer=2,
)


def start_anew(dims: ModelDimensions = SMALL) -> HybridWhisper:
    """An untrained model; its weights depend on torch's seed."""
    model = HybridWhisper(dims)
    model.initialise()
    return model


def start_from(name: str) -> HybridWhisper:
    """A model with the weights of an English Whisper model, to be fine-tuned.

    Its positions are cut to short sound, its vocabulary to the letters; all tokens
    that it will never write begin as their mean.

    Args:
        name: What whisper.load_model takes, such as "base.en".

    Raises:
        ModelError: The checkpoint is missing or damaged.
    """
    checkpoint = read_checkpoint(find_checkpoint(name))
    state = {key: weight.float() for key, weight in checkpoint.state.items()}
    for key, length in POSITIONS.items():
        state[key] = state[key][:length]
    full = state[EMBEDDING]
    is_unused = torch.ones(len(full), dtype=torch.bool)
    is_unused[list(WHISPER_IDS)] = False
    garbage = full[is_unused].mean(dim=0, keepdim=True)
    state[EMBEDDING] = torch.cat([full[list(WHISPER_IDS)], garbage])
    contexts = {"n_audio_ctx": SMALL.n_audio_ctx, "n_text_ctx": SMALL.n_text_ctx}
    model = HybridWhisper(replace(checkpoint.dims, **contexts))
    model.whisper.load_state_dict(state)
    return model

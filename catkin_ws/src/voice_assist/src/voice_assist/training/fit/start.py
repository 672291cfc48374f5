# SPDX-License-Identifier: BSD-3-Clause
"""Where training starts: from nothing, a Whisper model, or an earlier run's checkpoint."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import torch
from whisper.model import ModelDimensions

from voice_assist.errors import ModelError
from voice_assist.recognizer.checkpoint import Checkpoint, find_checkpoint, read_checkpoint
from voice_assist.recognizer.embedded import EMBEDDING, restore
from voice_assist.recognizer.hybrid import WhisperCtc
from voice_assist.recognizer.vocabulary import IDS_BY_SIZE
from voice_assist.training.fit.curriculum import CONTINUED, STAGES, WRITING, TrainingStage

POSITIONS = {"encoder.positional_embedding": 512, "decoder.positional_embedding": 192}
TEXT_LAYERS = 1  # kept of a Whisper decoder: letters need little, and each more costs 3 ms a pass

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


@dataclass(frozen=True, eq=False)
class Start:
    """A model to train, and the lessons that it still needs."""

    model: WhisperCtc
    stages: Sequence[TrainingStage]


def start_anew() -> Start:
    """An untrained model; its weights depend on torch's seed."""
    model = WhisperCtc(SMALL)
    model.initialise()
    return Start(model, STAGES)


def start_from(name: str, lesson: str = "mending") -> Start:
    """A model with the weights of a checkpoint, to be trained further.

    Args:
        name: A file of an earlier run, which has a CTC head and goes on as it is, or
            what whisper.load_model takes, such as "base.en", to be fine-tuned.
        lesson: What it goes on with, one of curriculum.LESSONS.

    Raises:
        ModelError: The checkpoint is missing or damaged, or has a vocabulary of another size.
    """
    checkpoint = read_checkpoint(find_checkpoint(name))
    if checkpoint.ctc is not None:
        return Start(restore(checkpoint), CONTINUED[lesson])
    return Start(_narrowed(checkpoint), (WRITING, *CONTINUED[lesson]))


def _narrowed(checkpoint: Checkpoint) -> WhisperCtc:
    """A Whisper model cut to short sound, to the letters and to a short decoder.

    All tokens that it will never write begin as their mean.
    """
    layers = min(checkpoint.dims.n_text_layer, TEXT_LAYERS)
    state = {k: v.float() for k, v in checkpoint.state.items() if _is_kept(k, layers)}
    for key, length in POSITIONS.items():
        state[key] = state[key][:length]
    full = state[EMBEDDING]
    if len(full) not in IDS_BY_SIZE:
        allowed = ", ".join(map(str, IDS_BY_SIZE))
        raise ModelError(f"a vocabulary of {len(full)} tokens to start from, allowed: {allowed}")
    ids = list(IDS_BY_SIZE[len(full)])
    is_unused = torch.ones(len(full), dtype=torch.bool)
    is_unused[ids] = False
    garbage = full[is_unused].mean(dim=0, keepdim=True)
    state[EMBEDDING] = torch.cat([full[ids], garbage])
    sizes = {"n_audio_ctx": SMALL.n_audio_ctx, "n_text_ctx": SMALL.n_text_ctx}
    model = WhisperCtc(replace(checkpoint.dims, **sizes, n_text_layer=layers))
    model.whisper.load_state_dict(state)
    return model


def _is_kept(key: str, layers: int) -> bool:
    """Whether a weight belongs to no decoder block, or to one of the first ones."""
    start = "decoder.blocks."
    return not key.startswith(start) or int(key[len(start) :].split(".")[0]) < layers

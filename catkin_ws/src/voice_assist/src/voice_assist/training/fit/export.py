# SPDX-License-Identifier: BSD-3-Clause
"""Write a trained model as a checkpoint that whisper.load_model reads."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path
from typing import Any

import torch
from torch import Tensor

from typed_config import replacing
from voice_assist.recognizer.embedded import EMBEDDING
from voice_assist.recognizer.hybrid import WhisperCtc
from voice_assist.recognizer.vocabulary import GARBAGE, N_VOCAB, WHISPER_IDS


def full_state(model: WhisperCtc) -> dict[str, Tensor]:
    """Whisper's state dict over the full vocabulary.

    Every unused token gets the garbage row, so that the full softmax equals the
    compact one.
    """
    state = dict(model.whisper.state_dict())
    compact = state[EMBEDDING]
    full = compact[GARBAGE].repeat(N_VOCAB, 1)
    full[list(WHISPER_IDS)] = compact[: len(WHISPER_IDS)]
    state[EMBEDDING] = full
    return state


def export(model: WhisperCtc, path: Path) -> None:
    """Write the checkpoint in half precision, compressed, all or nothing.

    Args:
        model: Trained.
        path: Replaced once the new file is complete.
    """
    dims = {**vars(model.dims), "n_vocab": N_VOCAB}
    state = {name: weight.half() for name, weight in full_state(model).items()}
    head = {name: weight.half() for name, weight in model.ctc.state_dict().items()}
    checkpoint: dict[str, Any] = {"dims": dims, "model_state_dict": state}
    checkpoint["ctc_state_dict"] = head
    plain = io.BytesIO()
    torch.save(checkpoint, plain)
    with replacing(path, ".tmp") as temporary:
        _compress(plain, temporary)


def _compress(plain: io.BytesIO, path: Path) -> None:
    """Deflate a checkpoint: the many equal embedding rows shrink to nothing."""
    with (
        zipfile.ZipFile(plain) as source,
        zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as target,
    ):
        for entry in source.infolist():
            fixed = zipfile.ZipInfo(entry.filename)  # dated 1980: same bytes each time
            fixed.compress_type = zipfile.ZIP_DEFLATED
            target.writestr(fixed, source.read(entry.filename))

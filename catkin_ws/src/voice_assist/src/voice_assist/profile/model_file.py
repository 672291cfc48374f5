# SPDX-License-Identifier: BSD-3-Clause
"""The file of adapted weights: only the tensors that differ from the base, and whose base it is."""

from __future__ import annotations

import io
from pathlib import Path
from tempfile import TemporaryDirectory

import torch
from torch import Tensor

from voice_assist.errors import ModelError
from voice_assist.recognizer.hybrid import WhisperCtc
from voice_assist.recognizer.safe_weights import check_weights, read_weights

NAME = "model.pt"  # in a profile
_BASE, _STATE = "base_sha256", "state"


def to_bytes(state: dict[str, Tensor], base_sha256: str) -> bytes:
    """As torch.save writes it, by weights only; half precision halves the file.

    Args:
        state: Adapted tensors by their name in WhisperCtc.
        base_sha256: Of the checkpoint that they belong to.
    """
    file = io.BytesIO()
    halves = {name: tensor.half() for name, tensor in state.items()}
    torch.save({_BASE: base_sha256, _STATE: halves}, file)
    return file.getvalue()


def read_model(data: bytes, model: WhisperCtc, base_sha256: str) -> dict[str, Tensor]:
    """Adapted tensors, each compared with the base's shape.

    Args:
        data: Of the file.
        model: The base.
        base_sha256: Of the base's checkpoint.

    Raises:
        ModelError: The file is damaged, belongs to another base, or holds what is no number.
    """
    with TemporaryDirectory() as folder:  # the reader compares an archive's sums in its file
        path = Path(folder) / NAME
        path.write_bytes(data)
        content, _ = read_weights(path)
    if not isinstance(content, dict) or content.keys() != {_BASE, _STATE}:
        raise ModelError(f"{NAME}: holds other things, allowed: {_BASE!r} and {_STATE!r}")
    if content[_BASE] != base_sha256:
        found = f"belongs to the base {str(content[_BASE])[:12]}"
        raise ModelError(f"{NAME}: {found}, allowed: {base_sha256[:12]}, the recogniser in use")
    state = content[_STATE]
    known = {name: tuple(p.shape) for name, p in model.named_parameters()}
    names = [name for name in known if isinstance(state, dict) and name in state]
    if not names:
        raise ModelError(f"{NAME}: no tensor of the recogniser in it, allowed: at least one")
    shapes = {name: known[name] for name in names}
    checked = check_weights(f"{NAME}: adapted weights", state, shapes)
    return {name: tensor.float() for name, tensor in checked.items()}

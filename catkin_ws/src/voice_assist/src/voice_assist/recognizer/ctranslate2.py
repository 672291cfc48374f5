# SPDX-License-Identifier: BSD-3-Clause
"""Whisper models in CTranslate2's format, version 6, as OpenAI's checkpoints.

The file is a list of named arrays. Queries, keys and values of self attention are stacked in one,
keys and values of cross attention in another; keys have no bias in OpenAI's format.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence
from math import prod
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from voice_assist.errors import ModelError
from voice_assist.recognizer.safe_weights import write_weights

VERSION, KIND = 6, "WhisperSpec"
TYPES = {0: "<f4", 1: "<i1", 2: "<i2", 3: "<i4", 4: "<f2"}
MAX_DIMS = 8
HEAD = 64  # width of one attention head in every size of Whisper

Arrays = Mapping[str, NDArray[np.generic]]


def convert(parts: Sequence[Path], out: Path) -> None:
    """Write an OpenAI checkpoint with the weights of a model, in half precision.

    Args:
        parts: The file, in one part or several.
        out: Checkpoint to write, all or nothing.

    Raises:
        ModelError: The parts cannot be read, or hold another model.
    """
    try:
        content = b"".join(part.read_bytes() for part in parts)
    except OSError as error:
        raise ModelError(f"{error.filename}: {error.strerror}") from error
    what = " + ".join(map(str, parts))
    try:
        checkpoint = openai_checkpoint(read_arrays(content))
    except (struct.error, KeyError, ValueError, UnicodeDecodeError) as error:
        raise ModelError(f"{what}: no Whisper model of CTranslate2: {error}") from error
    write_weights(checkpoint, out)


def read_arrays(content: bytes) -> dict[str, NDArray[np.generic]]:
    """Arrays of a file, by name.

    Raises:
        struct.error: The file ends too early.
        ValueError: It is of another version or kind, or an array does not fit its shape.
    """
    reader = _Reader(content)
    version, kind = reader.number("I"), reader.text()
    if (version, kind) != (VERSION, KIND):
        raise ValueError(f"version {version} of {kind!r}, allowed: {VERSION} of {KIND!r}")
    reader.number("I")  # revision
    arrays = {}
    for _ in range(reader.number("I")):
        name, rank = reader.text(), reader.number("B")
        if rank > MAX_DIMS:
            raise ValueError(f"{name}: {rank} dimensions, allowed: {MAX_DIMS}")
        shape = [reader.number("I") for _ in range(rank)]
        arrays[name] = reader.array(name, shape)
    return arrays


def openai_checkpoint(arrays: Arrays) -> dict[str, object]:
    """What `whisper.load_model` reads, from arrays by CTranslate2's names.

    Raises:
        KeyError: An array is missing.
        ValueError: One is quantised to whole numbers.
    """
    state: dict[str, Tensor] = {}
    for part in ("encoder", "decoder"):
        for layer in range(_layers(arrays, part)):
            state |= _block(arrays, part, layer)
    state |= _linear(arrays, "encoder/conv1", "encoder.conv1")
    state |= _linear(arrays, "encoder/conv2", "encoder.conv2")
    state |= _norm(arrays, "encoder/layer_norm", "encoder.ln_post")
    state |= _norm(arrays, "decoder/layer_norm", "decoder.ln")
    for part in ("encoder", "decoder"):
        name = f"{part}/position_encodings/encodings"
        state[f"{part}.positional_embedding"] = _tensor(arrays, name)
    state["decoder.token_embedding.weight"] = _tensor(arrays, "decoder/embeddings/weight")
    width = state["encoder.conv1.weight"].shape[0]
    text = state["decoder.positional_embedding"].shape
    dims = {
        "n_mels": state["encoder.conv1.weight"].shape[1],
        "n_audio_ctx": state["encoder.positional_embedding"].shape[0],
        "n_audio_state": width,
        "n_audio_head": width // HEAD,
        "n_audio_layer": _layers(arrays, "encoder"),
        "n_vocab": state["decoder.token_embedding.weight"].shape[0],
        "n_text_ctx": text[0],
        "n_text_state": text[1],
        "n_text_head": text[1] // HEAD,
        "n_text_layer": _layers(arrays, "decoder"),
    }
    return {"dims": dims, "model_state_dict": state}


class _Reader:
    def __init__(self, content: bytes) -> None:
        self._content, self._at = content, 0

    def number(self, kind: str) -> int:
        value: int = struct.unpack_from(f"<{kind}", self._content, self._at)[0]
        self._at += struct.calcsize(f"<{kind}")
        return value

    def text(self) -> str:
        return self._take(self.number("H")).rstrip(b"\0").decode()

    def array(self, name: str, shape: Sequence[int]) -> NDArray[np.generic]:
        kind = self.number("B")
        if kind not in TYPES:
            raise ValueError(f"{name}: type {kind}, allowed: {', '.join(map(str, TYPES))}")
        data = self._take(self.number("I"))
        dtype = np.dtype(TYPES[kind])
        if len(data) != prod(shape) * dtype.itemsize:
            raise ValueError(f"{name}: {len(data)} bytes for shape {tuple(shape)}")
        return np.frombuffer(data, dtype).reshape(shape)

    def _take(self, size: int) -> bytes:
        found = self._content[self._at : self._at + size]
        if len(found) < size:
            raise struct.error(f"it ends after {len(self._content)} bytes")
        self._at += size
        return found


def _layers(arrays: Arrays, part: str) -> int:
    names = (name.split("/") for name in arrays)
    return len({name[1] for name in names if name[0] == part and len(name) > 3})


def _block(arrays: Arrays, part: str, layer: int) -> dict[str, Tensor]:
    theirs, ours = f"{part}/layer_{layer}", f"{part}.blocks.{layer}"
    state = _attention(
        arrays, f"{theirs}/self_attention", f"{ours}.attn", ("query", "key", "value")
    )
    if part == "decoder":
        name = f"{theirs}/attention"
        state |= _attention(arrays, name, f"{ours}.cross_attn", ("query",), ("key", "value"))
    state |= _norm(arrays, f"{theirs}/ffn/layer_norm", f"{ours}.mlp_ln")
    state |= _linear(arrays, f"{theirs}/ffn/linear_0", f"{ours}.mlp.0")
    return state | _linear(arrays, f"{theirs}/ffn/linear_1", f"{ours}.mlp.2")


def _attention(arrays: Arrays, theirs: str, ours: str, *stacks: Sequence[str]) -> dict[str, Tensor]:
    state = _norm(arrays, f"{theirs}/layer_norm", f"{ours}_ln")
    for index, names in enumerate((*stacks, ("out",))):
        stacked = _linear(arrays, f"{theirs}/linear_{index}", "")
        for kind, values in stacked.items():
            for name, one in zip(names, values.chunk(len(names)), strict=True):
                state[f"{ours}.{name}{kind}"] = one.clone()
    state.pop(f"{ours}.key.bias")
    return state


def _linear(arrays: Arrays, theirs: str, ours: str) -> dict[str, Tensor]:
    return {f"{ours}.{kind}": _tensor(arrays, f"{theirs}/{kind}") for kind in ("weight", "bias")}


def _norm(arrays: Arrays, theirs: str, ours: str) -> dict[str, Tensor]:
    names = {"weight": "gamma", "bias": "beta"}
    return {f"{ours}.{our}": _tensor(arrays, f"{theirs}/{their}") for our, their in names.items()}


def _tensor(arrays: Arrays, name: str) -> Tensor:
    """An array as it is; whole numbers are quantised weights, which mean nothing without scales."""
    values = arrays[name]
    if values.dtype.kind != "f":
        allowed = "float32 or float16, as of a conversion without quantization to whole numbers"
        raise ValueError(f"{name} is of type {values.dtype.name}, allowed: {allowed}")
    return torch.from_numpy(np.array(values)).half()

# SPDX-License-Identifier: BSD-3-Clause
"""Untrusted weight files: no code runs, sizes are checked before allocation, numbers are finite."""

from __future__ import annotations

import hashlib
import pickle
import zipfile
from collections.abc import Mapping
from pathlib import Path

import torch
from torch import Tensor

from voice_assist.errors import ModelError

LARGEST = 8_000_000_000  # [B] of all records, unpacked; OpenAI's largest model has 6.2 GB
ALLOWED = "plain tensors in a zip archive as torch.save writes it"
FLOATS = torch.float64, torch.float32, torch.float16, torch.bfloat16
ENCODER_SHA256, STATE = "encoder_sha256", "state"  # keys of a file for one encoder
Shapes = Mapping[str, tuple[int, ...]]


def read_weights(path: Path) -> tuple[object, str]:
    """Content of a file that torch.save wrote, by weights only, and the file's SHA-256.

    Raises:
        ModelError: The file is missing, damaged, too large, or holds more than plain tensors.
    """
    try:
        _check_archive(path)
        content = torch.load(path, map_location="cpu", weights_only=True)
        return content, hashlib.sha256(path.read_bytes()).hexdigest()
    except ModelError:
        raise
    except OSError as error:
        words = error.strerror or _first(error)
        raise ModelError(f"{path} cannot be read: {words}; allowed: {ALLOWED}") from error
    except pickle.UnpicklingError as error:
        words = f"{path} holds no plain weights: {_first(error)}; allowed: {ALLOWED}"
        raise ModelError(words) from error
    except Exception as error:  # damaged bytes make zipfile and the unpickler raise anything
        raise ModelError(f"{path} is damaged: {_first(error)}; allowed: {ALLOWED}") from error


def write_weights(content: object, path: Path) -> None:
    """Write tensors as torch.save does, all or nothing: a crash leaves the old file."""
    temporary = path.with_suffix(".tmp")
    torch.save(content, temporary)
    temporary.replace(path)


def read_for_encoder(path: Path) -> tuple[str, object, str]:
    """What `write_for_encoder` wrote.

    Returns:
        SHA-256 of the encoder's file, the weights, and SHA-256 of this file.

    Raises:
        ModelError: As `read_weights`, or the file holds something else.
    """
    content, digest = read_weights(path)
    if not isinstance(content, dict) or content.keys() != {ENCODER_SHA256, STATE}:
        given = ", ".join(map(str, content)) if isinstance(content, dict) else "no mapping"
        raise ModelError(f"{path} holds {given:.200}, allowed: {ENCODER_SHA256} and {STATE}")
    return str(content[ENCODER_SHA256]), content[STATE], digest


def write_for_encoder(state: Mapping[str, Tensor], encoder_sha256: str, path: Path) -> None:
    """Write weights of use with one encoder only, all or nothing.

    Args:
        state: Tensors by name.
        encoder_sha256: Of that recogniser's checkpoint file, hexadecimal.
        path: File to write.
    """
    write_weights({ENCODER_SHA256: encoder_sha256, STATE: dict(state)}, path)


def check_weights(what: str, state: object, shapes: Shapes) -> dict[str, Tensor]:
    """The tensors of `state`, if they are those of a network.

    Args:
        what: Names file and part in the error.
        state: Tensors by name.
        shapes: Name and shape of every tensor of the network.

    Raises:
        ModelError: One is missing, unknown, of another shape or type, or holds NaN or infinity.
    """
    if not isinstance(state, dict):
        raise ModelError(f"{what} is {type(state).__name__}, allowed: tensors by name")
    missing, unknown = shapes.keys() - state.keys(), state.keys() - shapes.keys()
    for word, names in (("missing", missing), ("unknown", unknown)):
        if names:
            few = ", ".join(sorted(map(str, names))[:3])
            allowed = f"allowed: exactly the {len(shapes)} tensors of the network"
            raise ModelError(f"{what}: {len(names)} {word}, such as {few}; {allowed}")
    for name, shape in shapes.items():
        _check_tensor(f"{what}: {name}", state[name], shape)
    return state


def _check_tensor(what: str, tensor: object, shape: tuple[int, ...]) -> None:
    if not isinstance(tensor, Tensor) or tensor.layout is not torch.strided:
        raise ModelError(f"{what} is {type(tensor).__name__}, allowed: a dense tensor")
    if tuple(tensor.shape) != shape:
        raise ModelError(f"{what} has the shape {tuple(tensor.shape)}, allowed: {shape}")
    if tensor.dtype not in FLOATS:
        raise ModelError(f"{what} is of {tensor.dtype}, allowed: one of {FLOATS}")
    extremes = torch.stack(torch.aminmax(tensor)) if tensor.numel() else tensor  # NaN is both
    if not bool(torch.isfinite(extremes).all()):
        bad = int((~torch.isfinite(tensor)).sum())
        raise ModelError(f"{what} holds {bad} NaN or infinite, allowed: finite numbers only")


def _check_archive(path: Path) -> None:
    """Look at sizes first, then compare every record with its check sum, which torch does not.

    Raises:
        ModelError: The file is no archive, or would need too much memory.
        zipfile.BadZipFile: A record is damaged.
    """
    with path.open("rb"):  # a file that cannot be read says so here
        pass
    if not zipfile.is_zipfile(path):
        raise ModelError(f"{path} is no zip archive, allowed: {ALLOWED}")
    with zipfile.ZipFile(path) as archive:
        size = sum(record.file_size for record in archive.infolist())
        if size > LARGEST:
            raise ModelError(f"{path} unpacks to {size} bytes, allowed: at most {LARGEST}")
        damaged = archive.testzip()
    if damaged is not None:
        raise zipfile.BadZipFile(f"record {damaged} does not match its check sum")


def _first(error: Exception) -> str:
    """First line of an error of a library, which may be a page, or its kind if it says nothing."""
    lines = str(error).strip().splitlines()
    return lines[0][:200] if lines else type(error).__name__

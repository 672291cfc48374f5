# SPDX-License-Identifier: BSD-3-Clause
"""Find and read checkpoints in OpenAI's format, without running code in them."""

from __future__ import annotations

import hashlib
import os
import pickle
import zipfile
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import torch
import whisper
from torch import Tensor
from whisper.model import ModelDimensions

from voice_assist.errors import ModelError

EMBEDDED = "embedded"
EMBEDDED_PATH = Path(__file__).resolve().parents[3] / "models" / "embedded.pt"


@dataclass(frozen=True, eq=False)
class Checkpoint:
    """A checkpoint file's content."""

    dims: ModelDimensions
    state: dict[str, Tensor]  # of whisper.model.Whisper
    ctc: dict[str, Tensor] | None  # of the CTC head; None for OpenAI's models
    sha256: str  # of the file, hexadecimal


def find_checkpoint(model: str) -> Path:
    """File of a model, fetched by the whisper library if it is one of OpenAI's.

    Raises:
        ModelError: There is no such model, or it could not be fetched.
    """
    if model == EMBEDDED:
        path = EMBEDDED_PATH
    elif model in whisper.available_models():
        path = _fetch(model)
    else:
        path = Path(model).expanduser()
    if not path.is_file():
        names = ", ".join([EMBEDDED, *whisper.available_models()])
        raise ModelError(f"model {model!r}: no file {path}; allowed: a file or {names}")
    return path


def read_checkpoint(path: Path) -> Checkpoint:
    """Read a checkpoint by weights only.

    Raises:
        ModelError: The file is damaged, or is no Whisper checkpoint.
    """
    try:
        _check_sums(path)
        content = torch.load(path, map_location="cpu", weights_only=True)
    except (RuntimeError, EOFError, OSError, ValueError, zlib.error, zipfile.BadZipFile) as error:
        raise ModelError(f"{path} is damaged: {error}") from error
    except pickle.UnpicklingError as error:
        raise ModelError(f"{path} holds no plain weights: {error}") from error
    if not isinstance(content, dict) or not {"dims", "model_state_dict"} <= set(content):
        raise ModelError(f"{path} lacks 'dims' or 'model_state_dict', a checkpoint's keys")
    digest = hashlib.sha256(path.read_bytes()).hexdigest()
    dims = _dimensions(path, content["dims"])
    state = content["model_state_dict"]
    return Checkpoint(dims, state, content.get("ctc_state_dict"), digest)


def _check_sums(path: Path) -> None:
    """Compare every record with its check sum, which torch does not.

    Raises:
        zipfile.BadZipFile: A record is damaged.
    """
    if zipfile.is_zipfile(path):
        with zipfile.ZipFile(path) as archive:
            damaged = archive.testzip()
        if damaged is not None:
            raise zipfile.BadZipFile(f"record {damaged} does not match its check sum")


def _dimensions(path: Path, dims: Any) -> ModelDimensions:
    try:
        return ModelDimensions(**dims)
    except TypeError as error:
        raise ModelError(f"{path}: its dims are not Whisper's: {error}") from error


def _fetch(name: str) -> Path:
    """Let the whisper library download a model, or find it in its cache."""
    root = Path(os.getenv("XDG_CACHE_HOME", Path.home() / ".cache")) / "whisper"
    url = whisper._MODELS[name]  # the library has no public way to a model's file
    path = root / Path(url).name
    if not path.is_file():
        try:
            whisper.load_model(name, "cpu", str(root))
        except (OSError, RuntimeError) as error:
            reason = f"model {name!r} is not in {root} and cannot be fetched: {error}"
            raise ModelError(f"{reason}; works offline: {EMBEDDED!r}") from error
    return path

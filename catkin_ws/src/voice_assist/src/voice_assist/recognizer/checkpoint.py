# SPDX-License-Identifier: BSD-3-Clause
"""Find and read checkpoints in OpenAI's format, without running code in them."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import whisper
from torch import Tensor
from whisper.model import ModelDimensions

from typed_config import package_folder
from voice_assist.errors import ModelError
from voice_assist.recognizer.safe_weights import check_weights, read_weights
from voice_assist.recognizer.vocabulary import BLANK
from voice_assist.recognizer.whisper_shapes import read_dims, whisper_shapes
from voice_assist.types import LONGEST

STATE, CTC = "model_state_dict", "ctc_state_dict"
NEEDED = {"dims", STATE}
MIN_POSITIONS = round(LONGEST * 50)  # of the encoder: one for 20 ms
EMBEDDED = "embedded"
MULTILINGUAL = "multilingual"  # Whisper base, once it is fetched
FETCH = "`make languages` fetches Whisper base, which hears de, es, fr and ja"
EMBEDDED_PATH = package_folder("voice_assist") / "models" / "embedded.pt"


def multilingual_path() -> Path:
    """File of the multilingual model: in the user's own data, for set-up alone writes it."""
    data = os.environ.get("XDG_DATA_HOME") or Path.home() / ".local" / "share"
    return Path(data) / "voice_assist" / "models" / "whisper-base.pt"


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
    elif model == MULTILINGUAL:
        path = multilingual_path()
        if not path.is_file():
            raise ModelError(f"model {model!r}: no file {path}; {FETCH}")
    elif model in whisper.available_models():
        path = _fetch(model)
    else:
        path = _in_home(model)
    if not path.is_file():
        names = ", ".join([EMBEDDED, MULTILINGUAL, *whisper.available_models()])
        raise ModelError(f"model {model!r}: no file {path}; allowed: a file or {names}")
    return path


def read_checkpoint(path: Path) -> Checkpoint:
    """Read a checkpoint by weights only; sizes are compared before anything is built of them.

    Raises:
        ModelError: The file is damaged, is no Whisper checkpoint, or holds what is no number.
    """
    content, digest = read_weights(path)
    if not isinstance(content, dict) or content.keys() not in (NEEDED, NEEDED | {CTC}):
        given = ", ".join(map(str, content)) if isinstance(content, dict) else "no mapping"
        allowed = "'dims' and 'model_state_dict', and 'ctc_state_dict' of this project's models"
        raise ModelError(f"{path} holds {given or 'nothing'}, allowed: {allowed}")
    dims = read_dims(str(path), content["dims"])
    if CTC in content and dims.n_audio_ctx < MIN_POSITIONS:
        allowed = f"at least {MIN_POSITIONS}, which {LONGEST:g} s of sound need"
        raise ModelError(f"{path}: dims.n_audio_ctx is {dims.n_audio_ctx}, allowed: {allowed}")
    what = f"{path}: weights do not fit its dims: "
    state = check_weights(f"{what}model_state_dict", content[STATE], whisper_shapes(dims))
    if CTC not in content:
        return Checkpoint(dims, state, None, digest)
    shapes = {"weight": (BLANK + 1, dims.n_audio_state), "bias": (BLANK + 1,)}
    return Checkpoint(dims, state, check_weights(f"{what}{CTC}", content[CTC], shapes), digest)


def _fetch(name: str) -> Path:
    """Let the whisper library download a model, or find it in its cache."""
    root = Path(os.getenv("XDG_CACHE_HOME") or _in_home("~/.cache")) / "whisper"
    url = whisper._MODELS[name]  # the library has no public way to a model's file
    path = root / Path(url).name
    if not path.is_file():
        try:
            whisper.load_model(name, "cpu", str(root))
        except (OSError, RuntimeError) as error:
            reason = f"model {name!r} is not in {root} and cannot be fetched: {error}"
            raise ModelError(f"{reason}; works offline: {EMBEDDED!r}") from error
    return path


def _in_home(path: str) -> Path:
    """The path with `~` as the home folder it stands for; as it is where there is none."""
    try:
        return Path(path).expanduser()
    except RuntimeError:  # no such user, or one without a home
        return Path(path)

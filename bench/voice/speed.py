# SPDX-License-Identifier: BSD-3-Clause
"""Time per model size for a 2 s clip: this package's way beside `whisper.transcribe`.

Weights of tiny, base and small are random: time does not depend on their values. Both ways write
TOKENS tokens and no timestamps, once, on one thread; `whisper.transcribe` pads to its 30 s,
and takes only models of that length: not the embedded one.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable

import numpy as np
import torch
import whisper
from whisper.model import ModelDimensions, Whisper

from support.figures import Figure
from voice_assist.assembly import limit_torch, make_recognizer
from voice_assist.config import load_voice_config
from voice_assist.recognizer.checkpoint import Checkpoint
from voice_assist.recognizer.recognizer import Recognizer
from voice_assist.recognizer.whisper import OpenAIRecognizer
from voice_assist.types import RATE, Samples

CLIP = 2.0  # [s]
TOKENS = 6  # written for the clip, as for a short command
REPEATS = 3
SHAPES = {"tiny": (384, 6, 4), "base": (512, 8, 6), "small": (768, 12, 12)}  # width, heads, layers


def measure() -> list[Figure]:
    """Time of the transcript, of the second opinion, and of `whisper.transcribe`."""
    config = load_voice_config()
    limit_torch(config)
    torch.manual_seed(0)
    sound = clip()
    figures = _rows("embedded", make_recognizer(config), sound, config.commands.phrases)
    for name in SHAPES:
        model = random_model(name)
        ours = OpenAIRecognizer(name, checkpoint(model), most_tokens=TOKENS)
        figures += _rows(name, ours, sound, config.commands.phrases)
        del ours
        figures += _theirs(name, model, sound)
    return figures


def random_model(name: str) -> Whisper:
    """A Whisper model of the true shape of an English-only size, with random weights.

    Args:
        name: A key of SHAPES.
    """
    width, heads, layers = SHAPES[name]
    dims = ModelDimensions(80, 1500, width, heads, layers, 51864, 448, width, heads, layers)
    model = Whisper(dims).eval()
    with torch.no_grad():  # the library leaves this one as it lay in memory
        model.decoder.positional_embedding.normal_(std=0.02)
    return model


def checkpoint(model: Whisper) -> Checkpoint:
    """What a file of the model would hold."""
    return Checkpoint(model.dims, model.state_dict(), None, "random")


def _rows(
    name: str, recognizer: Recognizer, sound: Samples, phrases: tuple[str, ...]
) -> list[Figure]:
    heard = _median(lambda: recognizer.transcribe(sound))
    opinion = _median(lambda: recognizer.score(sound, phrases))
    return [
        Figure(f"{name}: transcript of 2 s", 1e3 * heard, "ms"),
        Figure(f"{name}: second opinion on 2 s", 1e3 * opinion, "ms"),
        Figure(f"{name}: real-time factor of one transcript", heard / CLIP, ""),
    ]


def _theirs(name: str, model: Whisper, sound: Samples) -> list[Figure]:
    taken = _median(lambda: transcribe(model, sound, TOKENS))
    return [
        Figure(f"{name}: whisper.transcribe of 2 s", 1e3 * taken, "ms"),
        Figure(f"{name}: real-time factor of whisper.transcribe", taken / CLIP, ""),
    ]


def transcribe(model: Whisper, sound: Samples, tokens: int) -> str:
    """The library's own way, once and without timestamps.

    Args:
        model: English only, of 30 s.
        sound: At 16 kHz. Shape (n,).
        tokens: To write at most.
    """
    result = whisper.transcribe(
        model,
        sound,
        language="en",
        fp16=False,
        temperature=0.0,
        sample_len=tokens,
        without_timestamps=True,
        condition_on_previous_text=False,
    )
    return str(result["text"])


def _median(work: Callable[[], object]) -> float:
    """Median CPU time of some runs after one to warm up [s].

    On one thread that is the time to wait on an idle core; what else runs lengthens only the wait.
    """
    work()
    times = []
    for _ in range(REPEATS):
        begin = time.process_time()
        work()
        times.append(time.process_time() - begin)
    return float(np.median(times))


def clip() -> Samples:
    """Two seconds in which the level changes as in speech; what is said costs nothing here."""
    t = np.arange(round(CLIP * RATE)) / RATE
    noise = np.random.default_rng(0).standard_normal(len(t))
    return (0.1 * noise * np.sin(math.pi * 2.0 * t) ** 2).astype(np.float32)

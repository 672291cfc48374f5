# SPDX-License-Identifier: BSD-3-Clause
"""Word times of clips by forced alignment with the model's own CTC head."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray

from voice_assist.recognizer.ctc import best_alignment
from voice_assist.recognizer.hybrid import WhisperCtc
from voice_assist.recognizer.mel import SAMPLES_PER_STATE, log_mel
from voice_assist.recognizer.vocabulary import encode
from voice_assist.training.array_file import write_arrays
from voice_assist.training.cache_key import keyed
from voice_assist.training.data.mixture import Aligned, WordTime
from voice_assist.training.data.synthesis import TrainingClip
from voice_assist.training.precision import cheap_numbers
from voice_assist.types import RATE, Samples

WINDOW = 7 * RATE  # samples read at a time
MARGIN = RATE  # samples of context on each side
STEP = 0.02  # [s] between encoder states
WORST = -1.5  # mean log-probability per state below which a clip is left out


def align_clips(model: WhisperCtc, clips: Sequence[TrainingClip], cache: Path) -> list[Aligned]:
    """Word times of all clips that align well.

    Args:
        model: Trained far enough to follow the text.
        clips: With text, of any length.
        cache: File for the times, whose name gets a key of the clips; read where it exists.
            Not of the model: a run that goes on keeps the times that its stage began with.
    """
    cache = keyed(cache, clips)
    if cache.exists():
        with np.load(cache) as stored:
            times = [stored[f"t{index}"] for index in range(len(clips))]
    else:
        times = [_times(model, clip) for clip in clips]
        write_arrays(cache, **{f"t{index}": time for index, time in enumerate(times)})
    return list(_aligned(clips, times))


@torch.inference_mode()
def _times(model: WhisperCtc, clip: TrainingClip) -> NDArray[np.floating]:
    """Time of each character [s], empty where the clip does not align."""
    nothing = np.zeros(0)
    if not clip.text or len(clip.samples) < RATE // 10:
        return nothing
    quiet = np.zeros(RATE // 10, np.float32)
    sound = np.concatenate([quiet, clip.samples.astype(np.float32) / 32768, quiet])
    logprobs = long_logprobs(model, sound)
    score, frames = best_alignment(logprobs, np.array(encode(clip.text)))
    if score / len(logprobs) < WORST:
        return nothing
    return np.asarray(frames) * STEP - 0.1


def long_logprobs(model: WhisperCtc, sound: Samples) -> NDArray[np.float32]:
    """CTC log-probabilities of sound of any length, read through windows.

    Args:
        model: Its context must be longer than WINDOW and two MARGINs.
        sound: float32, 16 kHz. Shape (n,).

    Returns:
        Shape (n // SAMPLES_PER_STATE, classes).
    """
    parts = []
    for start in range(0, len(sound), WINDOW):
        first = max(start - MARGIN, 0)
        piece = torch.from_numpy(sound[first : start + WINDOW + MARGIN])[None]
        with cheap_numbers():
            logprobs = model.ctc_logprobs(model.encode(log_mel(piece)))[0].numpy()
        skip = (start - first) // SAMPLES_PER_STATE
        parts.append(logprobs[skip : skip + WINDOW // SAMPLES_PER_STATE])
    return np.concatenate(parts)


def _aligned(
    clips: Sequence[TrainingClip], times: Sequence[NDArray[np.floating]]
) -> Iterable[Aligned]:
    for clip, time in zip(clips, times, strict=True):
        if len(time):
            yield Aligned(clip, tuple(_words(clip.text, time)))


def _words(text: str, time: NDArray[np.floating]) -> Iterable[WordTime]:
    first = 0
    for word in text.split(" "):
        last = first + len(word) - 1
        start = max(float(time[first]) - 0.08, 0.0)
        yield WordTime(word, start, float(time[last]) + 0.08)
        first = last + 2

# SPDX-License-Identifier: BSD-3-Clause
"""Quick figures during training: transcripts of clips never trained on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from voice_assist.recognizer.hybrid import WhisperCtc
from voice_assist.recognizer.mel import log_mel
from voice_assist.recognizer.vocabulary import END, PROMPT, decode
from voice_assist.training.data.noise import Surroundings, background
from voice_assist.training.data.synthesis import TrainingClip
from voice_assist.training.data.texts import COMMANDS
from voice_assist.training.precision import cheap_numbers
from voice_assist.types import RATE, Samples

QUIET = 0.25  # [s] before and behind a clip
LONGEST = 163_200  # samples that are read; the encoder has 512 positions of 320
LETTERS = 24  # decoded at most; longer texts cannot come out as a command


@dataclass(frozen=True)
class TranscriptTally:
    """How a set of clips was written down."""

    n: int
    right: int  # transcript equals the first LETTERS of the text
    taken: int  # transcript is a command, though another was or none was said

    @property
    def accuracy(self) -> float:
        """Share of exact transcripts."""
        return self.right / max(self.n, 1)


def greedy(model: WhisperCtc, mel: Tensor, letters: int = LETTERS) -> list[str]:
    """Greedy transcripts of a batch, shape (batch, 80, frames)."""
    states = model.encode(mel)
    tokens = torch.tensor([PROMPT] * len(mel))
    is_open = torch.ones(len(mel), dtype=torch.bool)
    for _ in range(letters):
        best = model.logits(tokens, states)[:, -1].argmax(-1)
        best = torch.where(is_open, best, END)
        tokens = torch.cat([tokens, best[:, None]], dim=1)
        is_open &= best != END
        if not is_open.any():
            break
    return [decode(row) for row in tokens[:, len(PROMPT) :].tolist()]


@torch.inference_mode()
def transcripts(model: WhisperCtc, sounds: Sequence[Samples]) -> list[str]:
    """Greedy transcripts of clips of any lengths, each amid a little quiet."""
    order = sorted(range(len(sounds)), key=lambda i: len(sounds[i]))
    written = [""] * len(sounds)
    for start in range(0, len(order), 32):
        chosen = order[start : start + 32]
        longest = min(max(len(sounds[i]) for i in chosen) + int(2 * QUIET * RATE), LONGEST)
        batch = np.random.default_rng(0).normal(0, 1e-4, (len(chosen), longest))
        for row, index in zip(batch, chosen, strict=True):
            first = int(QUIET * RATE)
            kept = sounds[index][: longest - first]
            row[first : first + len(kept)] += kept
        with cheap_numbers():
            texts = greedy(model, log_mel(torch.from_numpy(batch.astype(np.float32))))
        for index, text in zip(chosen, texts, strict=True):
            written[index] = text.strip()
    return written


def tally(clips: Sequence[TrainingClip], written: Sequence[str]) -> TranscriptTally:
    """Count exact transcripts and wrong commands."""
    pairs = list(zip(clips, written, strict=True))
    return TranscriptTally(
        n=len(pairs),
        right=sum(clip.text[:LETTERS].strip() == text for clip, text in pairs),
        taken=sum(text in COMMANDS and text != clip.text for clip, text in pairs),
    )


def in_noise(
    clips: Sequence[TrainingClip], snr: float | None, around: Surroundings
) -> list[Samples]:
    """Clips as float32, with background at a signal-to-noise ratio [dB]; None: without."""
    rng = np.random.default_rng(5)
    sounds = []
    for clip in clips:
        sound: Samples = clip.samples.astype(np.float32) / np.float32(32768)
        if snr is not None:
            loud = np.sqrt(np.mean(sound**2))
            noise = background(around, len(sound), rng)
            sound += noise * np.float32(loud * 10 ** (-snr / 20))
        sounds.append(sound)
    return sounds

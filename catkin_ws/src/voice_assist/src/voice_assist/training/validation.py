# SPDX-License-Identifier: BSD-3-Clause
"""The figures that choose the checkpoint to keep."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from voice_assist.recognizer.hybrid import WhisperCtc
from voice_assist.training.data.corpus import Corpus
from voice_assist.training.data.synthesis import TrainingClip
from voice_assist.training.transcribe import TranscriptTally, in_noise, tally, transcripts


@dataclass(frozen=True)
class ValidationFigures:
    """Exact transcripts by set; synthetic voices and people apart."""

    quiet: TranscriptTally  # held-out synthetic commands
    noisy: TranscriptTally  # the same at 10 dB
    loud: TranscriptTally  # the same at 0 dB
    near: TranscriptTally  # held-out synthetic near misses
    stop: TranscriptTally  # human "stop", split dev
    words: TranscriptTally  # other human words, split dev
    talk: TranscriptTally  # human talk, a part of split false_accept_dev

    @property
    def score(self) -> float:
        """Commands heard, less three times the share of false commands."""
        heard = 0.25 * self.quiet.accuracy + 0.15 * self.noisy.accuracy
        heard += 0.2 * self.loud.accuracy + 0.4 * self.stop.accuracy
        parts = vars(self).values()
        false = sum(part.taken for part in parts) / max(sum(part.n for part in parts), 1)
        return heard - 3.0 * false

    def flat(self) -> dict[str, object]:
        """Figures as plain numbers for a log."""
        numbers: dict[str, object] = {"score": round(self.score, 4)}
        for name, part in vars(self).items():
            numbers[name] = f"{part.right}/{part.n}, false {part.taken}"
        return numbers


def measure(model: WhisperCtc, corpus: Corpus, thin: int = 2) -> ValidationFigures:
    """Transcribe clips never trained on.

    Args:
        model: To measure.
        corpus: Whose held-out, people and talk clips are used.
        thin: One clip in so many; human "stop" and near misses are used in full.
    """
    commands = [clip for clip in corpus.held_out if clip.kind == "command"]
    near = [clip for clip in corpus.held_out if clip.kind != "command"]
    stop = [clip for clip in corpus.people if clip.text == "stop"]
    words = [clip for clip in corpus.people if clip.text != "stop"]

    def read(clips: Sequence[TrainingClip], snr: float | None = None) -> TranscriptTally:
        return tally(clips, transcripts(model, in_noise(clips, snr, corpus.around)))

    return ValidationFigures(
        quiet=read(commands[::thin]),
        noisy=read(commands[:: 2 * thin], 10.0),
        loud=read(commands[:: 2 * thin], 0.0),
        near=read(near),
        stop=read(stop),
        words=read(words[:: 2 * thin]),
        talk=read(corpus.talk[::thin]),
    )

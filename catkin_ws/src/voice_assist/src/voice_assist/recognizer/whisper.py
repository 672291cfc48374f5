# SPDX-License-Identifier: BSD-3-Clause
"""Load any Whisper checkpoint as a recogniser, and OpenAI's own models' way."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import torch
from torch import Tensor
from whisper.decoding import DecodingOptions, DecodingTask
from whisper.model import Whisper

from voice_assist.errors import ModelError
from voice_assist.recognizer.checkpoint import (
    Checkpoint,
    find_checkpoint,
    read_checkpoint,
)
from voice_assist.recognizer.embedded import EmbeddedRecognizer, is_audible
from voice_assist.recognizer.hybrid import encode_short
from voice_assist.recognizer.mel import log_mel
from voice_assist.recognizer.recognizer import LONGEST, Recognizer, believed
from voice_assist.recognizer.scoring import ratios
from voice_assist.recognizer.verification import read_verifier
from voice_assist.types import RATE, Hypothesis, IsHopeless, Samples, never_hopeless

MOST_TOKENS = 64  # written for one sound; ten seconds of talk need about 40
QUIET = RATE  # samples of silence appended: models trained on 30 s expect an end


class ShortDecodingTask(DecodingTask):  # type: ignore[misc]  # untyped library
    """Whisper's own decoding, on encoder states of short sound."""

    def _get_audio_features(self, mel: Tensor) -> Tensor:
        return encode_short(self.model.encoder, mel)


class OpenAIRecognizer:
    """A Whisper model with OpenAI's vocabulary in full."""

    def __init__(
        self,
        name: str,
        checkpoint: Checkpoint,
        device: str = "cpu",
        most_tokens: int = MOST_TOKENS,
    ) -> None:
        """Take the weights.

        Args:
            name: As asked for.
            checkpoint: Of any size.
            device: A torch device.
            most_tokens: Written for one sound.
        """
        self.name, self.model_hash = name, checkpoint.sha256
        self.model = Whisper(checkpoint.dims)
        self.model.load_state_dict(checkpoint.state)
        self.model = self.model.to(device).float().eval()
        options = DecodingOptions(
            language="en",
            temperature=0.0,
            sample_len=most_tokens,
            without_timestamps=True,
            fp16=False,
        )
        self._task = ShortDecodingTask(self.model, options)

    def transcribe(self, samples: Samples, is_hopeless: IsHopeless = never_hopeless) -> Hypothesis:
        """Text of the sound, always written to its end; see Recognizer."""
        if not is_audible(samples):
            return Hypothesis("", 0.0, 1.0)
        with torch.inference_mode():
            result = self._task.run(self._mel(samples))[0]
        return believed(result.text, float(result.avg_logprob), result.no_speech_prob)

    def score(self, samples: Samples, phrases: Sequence[str]) -> dict[str, float]:
        """The decoder's opinion, over the usual spellings; see Recognizer."""
        if not is_audible(samples):
            return dict.fromkeys(phrases, float("-inf"))
        free = self.transcribe(samples).text
        rivals = ["", free] if _plain(free) not in phrases else [""]
        with torch.inference_mode():
            states = encode_short(self.model.encoder, self._mel(samples))
            found = {text: self._likelihood(states, [text]) for text in rivals}
            found |= {p: self._likelihood(states, _spellings(p)) for p in phrases}
        return ratios(found, phrases)

    def verify(self, samples: Samples, phrase: str) -> float:
        """It cannot; see Recognizer."""
        return float("inf")

    def _mel(self, samples: Samples) -> Tensor:
        heard = np.array(samples[-int(LONGEST * RATE) :], dtype=np.float32)
        limit = self.model.dims.n_audio_ctx * 320
        padded = np.pad(heard, (0, QUIET))[:limit]
        sound = torch.from_numpy(padded)[None].to(self.model.device)
        return log_mel(sound, self.model.dims.n_mels)

    def _likelihood(self, states: Tensor, spellings: Sequence[str]) -> float:
        """Log-probability of the likeliest of some spellings and its end."""
        tokenizer = self._task.tokenizer
        prompt = list(tokenizer.sot_sequence_including_notimestamps)
        lines = [
            tokenizer.encode(f" {text}", disallowed_special=()) if text else []
            for text in spellings
        ]
        width = max(map(len, lines)) + 1
        end = tokenizer.eot
        wanted = [[*line, *[end] * (width - len(line))] for line in lines]
        targets = torch.tensor(wanted, device=states.device)
        start = torch.tensor([prompt], device=states.device).expand(len(lines), -1)
        fed = torch.cat([start, targets[:, :-1]], dim=1)
        logits = self.model.decoder(fed, states.expand(len(lines), -1, -1))
        logprobs = logits[:, len(prompt) - 1 :].float().log_softmax(-1)
        chosen = logprobs.gather(-1, targets.unsqueeze(-1)).squeeze(-1)
        pairs = zip(chosen, lines, strict=True)
        return max(float(row[: len(line) + 1].sum()) for row, line in pairs)


def load_recognizer(model: str = "embedded", device: str = "cpu") -> Recognizer:
    """Load a recogniser.

    Args:
        model: "embedded", a name that whisper.load_model takes such as "base.en",
            or a checkpoint file.
        device: A torch device, "cpu" or "cuda".

    Raises:
        ModelError: The model is unknown, missing or damaged, or the device is not
            there.
    """
    try:
        torch.zeros(1, device=device)
    except (RuntimeError, AssertionError) as error:
        raise ModelError(f"device {device!r}: {error}; 'cpu' always works") from error
    path = find_checkpoint(model)
    checkpoint = read_checkpoint(path)
    try:
        if checkpoint.ctc is None:
            return OpenAIRecognizer(model, checkpoint, device)
        verifier = read_verifier(checkpoint.sha256, checkpoint.dims.n_audio_state)
        return EmbeddedRecognizer(model, checkpoint, device, verifier)
    except (RuntimeError, KeyError, IndexError) as error:
        raise ModelError(f"{path}: weights do not fit its dims: {error}") from error


def _spellings(phrase: str) -> list[str]:
    """How OpenAI's models write a short command."""
    capital = phrase[:1].upper() + phrase[1:]
    return [phrase, capital, f"{capital}.", f"{capital}!", f"{phrase}."]


def _plain(text: str) -> str:
    """Letters of a transcript, to see whether it is one of the phrases."""
    return " ".join("".join(c for c in text.lower() if c.isalpha() or c == " ").split())

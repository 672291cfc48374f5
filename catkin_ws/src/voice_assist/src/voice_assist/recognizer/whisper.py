# SPDX-License-Identifier: BSD-3-Clause
"""Load any Whisper checkpoint as a recogniser, and OpenAI's own models' way."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from torch import Tensor
from whisper.decoding import DecodingOptions, DecodingTask, GreedyDecoder
from whisper.model import LayerNorm, Whisper

from voice_assist.config.commands import ENGLISH
from voice_assist.errors import ModelError
from voice_assist.recognizer.checkpoint import (
    FETCH,
    Checkpoint,
    find_checkpoint,
    read_checkpoint,
)
from voice_assist.recognizer.embedded import EmbeddedRecognizer, is_audible
from voice_assist.recognizer.hybrid import encode_short
from voice_assist.recognizer.mel import SAMPLES_PER_STATE, log_mel
from voice_assist.recognizer.precision import AUTO, dtype_for
from voice_assist.recognizer.recognizer import Recognizer, drop_hallucination, is_same
from voice_assist.recognizer.scoring import ratios
from voice_assist.recognizer.token_tree import likelihoods
from voice_assist.recognizer.verification import read_verifier
from voice_assist.text.amounts import in_digits
from voice_assist.text.normalize import is_japanese, with_same_words
from voice_assist.types import LONGEST, RATE, Hypothesis, IsHopeless, Samples, never_hopeless

MAX_TOKENS = 64  # written for one sound; ten seconds of talk need about 40
QUIET = RATE  # samples of silence appended: models trained on 30 s expect an end
_THRICE = re.compile(r"(.{2,}?)\1\1")  # a text that begins with three equal parts


class _UntilHopeless(GreedyDecoder):  # type: ignore[misc]  # untyped library
    """Greedy decoding that ends where the caller says that the text cannot matter.

    It ends as well where the text begins anew: without 30 s of sound, a model does not see the end.
    """

    def __init__(self, task: DecodingTask) -> None:
        super().__init__(0.0, task.tokenizer.eot)
        self._task = task
        self.is_hopeless: IsHopeless = never_hopeless

    def update(
        self, tokens: Tensor, logits: Tensor, sum_logprobs: Tensor
    ) -> tuple[Tensor, bool | Tensor]:
        """One token more, and whether it is the last one."""
        tokens, is_over = super().update(tokens, logits, sum_logprobs)
        if is_over:
            return tokens, is_over
        written = self._task.tokenizer.decode(tokens[0, self._task.sample_begin :].tolist())
        return tokens, once(written) != written or self.is_hopeless(written)


class _ShortDecodingTask(DecodingTask):  # type: ignore[misc]  # untyped library
    """Whisper's own decoding, of the encoder's states of short sound."""

    def __init__(self, model: Whisper, options: DecodingOptions) -> None:
        super().__init__(model, options)
        self.decoder = _UntilHopeless(self)

    def _get_audio_features(self, mel: Tensor) -> Tensor:
        return mel  # `run` is given states


@dataclass(eq=False)
class _Listened:
    """A sound, the encoder's states of it, and its whole text once it is written."""

    sound: Samples
    states: Tensor  # (1, time, d)
    text: Hypothesis | None = None


class OpenAIRecognizer:
    """A Whisper model with OpenAI's vocabulary in full."""

    def __init__(
        self,
        name: str,
        checkpoint: Checkpoint,
        device: str = "cpu",
        max_tokens: int = MAX_TOKENS,
        dtype: torch.dtype | None = None,
        language: str = ENGLISH,
    ) -> None:
        """Take the weights.

        Args:
            name: As asked for.
            checkpoint: Of any size.
            device: A torch device.
            max_tokens: Written for one sound.
            dtype: Of the weights; None: the device's best.
            language: That it hears, by Whisper's token.

        Raises:
            ModelError: It hears English only, and another language is asked for.
        """
        self.name, self.model_hash = name, checkpoint.sha256
        self.dtype = dtype or dtype_for(device)
        self.model = Whisper(checkpoint.dims)
        if language != ENGLISH and not self.model.is_multilingual:
            raise ModelError(f"model {name!r} hears English only, not {language!r}; {FETCH}")
        self.model.load_state_dict(checkpoint.state)
        self.model = self.model.to(device, self.dtype).eval()
        for module in self.model.modules():
            if isinstance(module, LayerNorm):
                module.float()  # Whisper computes it so
        options = DecodingOptions(
            language=language,
            temperature=0.0,
            sample_len=max_tokens,
            without_timestamps=True,
            fp16=False,
        )
        self._task = _ShortDecodingTask(self.model, options)
        self._newest: _Listened | None = None

    def transcribe(self, samples: Samples, is_hopeless: IsHopeless = never_hopeless) -> Hypothesis:
        """Text of the sound; where it is hopeless, only its beginning. See Recognizer."""
        if not is_audible(samples):
            return Hypothesis("", 0.0, 1.0)
        return self._write(self._listen(samples), is_hopeless)

    def score(self, samples: Samples, phrases: Sequence[str]) -> dict[str, float]:
        """The decoder's opinion, over the usual spellings; see Recognizer."""
        if not is_audible(samples):
            return dict.fromkeys(phrases, float("-inf"))
        heard = self._listen(samples)
        free = (heard.text or self._write(heard, never_hopeless)).text
        texts = {phrase: _spellings(phrase) for phrase in phrases}
        if written := with_same_words(free, phrases):
            texts[written].append(free.strip())
        texts |= {text: [text] for text in (("",) if written else ("", free))}
        return ratios(self._best_of(heard, texts), phrases)

    def likelihoods(self, samples: Samples, texts: Mapping[str, Sequence[str]]) -> dict[str, float]:
        """Log-likelihood [nat] of each phrase in a sound, by the likeliest way to write it.

        Args:
            samples: As for transcribe, audible.
            texts: Per phrase all that it may be written as.
        """
        written = {
            p: [way for text in some for way in _spellings(text)] for p, some in texts.items()
        }
        return self._best_of(self._listen(samples), written)

    def _best_of(self, heard: _Listened, texts: Mapping[str, Sequence[str]]) -> dict[str, float]:
        lines = {text: self._tokens(text) for some in texts.values() for text in some}
        tokenizer, decoder = self._task.tokenizer, self.model.decoder
        prompt = tokenizer.sot_sequence_including_notimestamps
        with torch.inference_mode():
            found = likelihoods(decoder, heard.states, prompt, list(lines.values()), tokenizer.eot)
        likely = dict(zip(lines, found, strict=True))
        return {text: max(likely[t] for t in some) for text, some in texts.items()}

    def verify(self, samples: Samples, phrase: str) -> float:
        """It cannot; see Recognizer."""
        return float("inf")

    def _listen(self, samples: Samples) -> _Listened:
        """Encode a sound; the one that was just heard is not encoded again."""
        newest = self._newest
        if newest is not None and is_same(newest.sound, samples):
            return newest
        heard = np.array(samples[-int(LONGEST * RATE) :], dtype=np.float32)
        limit = self.model.dims.n_audio_ctx * SAMPLES_PER_STATE
        padded = np.pad(heard, (0, QUIET))[:limit]
        sound = torch.from_numpy(padded)[None].to(self.model.device)
        with torch.inference_mode():
            mel = log_mel(sound, self.model.dims.n_mels).to(self.dtype)
            self._newest = _Listened(samples, encode_short(self.model.encoder, mel))
        return self._newest

    def _tokens(self, text: str) -> list[int]:
        """Of a text as it stands behind the prompt; odd letters can take more than were written."""
        most = min(self._task.sample_len, self._task.n_ctx - self._task.sample_begin - 1)
        encode = self._task.tokenizer.encode
        written = text if is_japanese(text) else f" {text}"  # which has no space before a word
        return encode(written, disallowed_special=())[:most] if text else []

    def _write(self, heard: _Listened, is_hopeless: IsHopeless) -> Hypothesis:
        was_cut = False

        def is_over(text: str) -> bool:
            nonlocal was_cut
            was_cut = is_hopeless(text)
            return was_cut

        self._task.decoder.is_hopeless = is_over
        with torch.inference_mode():
            result = self._task.run(heard.states)[0]
        text = drop_hallucination(
            once(result.text), float(result.avg_logprob), result.no_speech_prob
        )
        if not was_cut:
            heard.text = text
        return text


def once(text: str) -> str:
    """The first of equal parts that a text begins with; the text, if it does not begin so.

    A Japanese text has to begin with three of them: there two of a few characters are a word.
    """
    if is_japanese(text):
        thrice = _THRICE.match(text.strip())
        return thrice[1] if thrice else text
    words, plain = text.split(), [_plain(word) for word in text.split()]
    for n in range(1, len(words) // 2 + 1):
        if plain[:n] == plain[n : 2 * n]:
            return " ".join(words[:n])
    return text


def load_recognizer(
    model: str = "embedded", device: str = "cpu", precision: str = AUTO
) -> Recognizer:
    """Load a recogniser.

    Args:
        model: "embedded", a name that whisper.load_model takes such as "base.en",
            or a checkpoint file.
        device: A torch device, "cpu" or "cuda".
        precision: Of its numbers, as for `dtype_for`.

    Raises:
        ModelError: The model is unknown, missing or damaged, or the device is not
            there or does not have that precision.
    """
    path, checkpoint = _checkpoint(model, device)
    dtype = dtype_for(device, precision)
    try:
        if checkpoint.ctc is None:
            return OpenAIRecognizer(model, checkpoint, device, dtype=dtype)
        verifier = read_verifier(checkpoint.sha256, checkpoint.dims.n_audio_state)
        return EmbeddedRecognizer(model, checkpoint, device, verifier, dtype)
    except (RuntimeError, KeyError, IndexError) as error:
        raise ModelError(f"{path}: weights do not fit its dims: {error}") from error


def load_multilingual(
    model: str, device: str, language: str, precision: str = AUTO
) -> OpenAIRecognizer:
    """Load a model that hears another language than English.

    Args:
        model: As for load_recognizer.
        device: A torch device.
        language: By Whisper's token.
        precision: As for load_recognizer.

    Raises:
        ModelError: As for load_recognizer, or the model hears English only.
    """
    path, checkpoint = _checkpoint(model, device)
    if checkpoint.ctc is not None:
        raise ModelError(f"model {model!r} hears English only, not {language!r}; {FETCH}")
    dtype = dtype_for(device, precision)
    try:
        return OpenAIRecognizer(model, checkpoint, device, dtype=dtype, language=language)
    except (RuntimeError, KeyError, IndexError) as error:
        raise ModelError(f"{path}: weights do not fit its dims: {error}") from error


def _checkpoint(model: str, device: str) -> tuple[Path, Checkpoint]:
    try:
        torch.zeros(1, device=device)
    except (RuntimeError, AssertionError) as error:
        raise ModelError(f"device {device!r}: {error}; 'cpu' always works") from error
    path = find_checkpoint(model)
    return path, read_checkpoint(path)


def _spellings(phrase: str) -> list[str]:
    """How OpenAI's models write a short command; an amount in digits, too."""
    found = []
    for text in dict.fromkeys((phrase, in_digits(tuple(phrase.split())))):
        capital = text[:1].upper() + text[1:]
        found += [text, capital, f"{capital}.", f"{capital}!", f"{text}."]
    return found


def _plain(text: str) -> str:
    """Letters of a transcript, to see whether it is one of the phrases."""
    return " ".join("".join(c for c in text.lower() if c.isalpha() or c == " ").split())

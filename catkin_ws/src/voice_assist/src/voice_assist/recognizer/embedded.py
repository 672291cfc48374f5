# SPDX-License-Identifier: BSD-3-Clause
"""The recogniser of this project's own small checkpoint."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import torch
from torch import Tensor, nn
from whisper.audio import HOP_LENGTH

from voice_assist.recognizer.checkpoint import Checkpoint
from voice_assist.recognizer.ctc import greedy_text
from voice_assist.recognizer.hybrid import Memory, WhisperCtc, encode_lower, encode_upper
from voice_assist.recognizer.mel import log_mel
from voice_assist.recognizer.precision import STEP, dtype_for, in_one_call, quick
from voice_assist.recognizer.recognizer import SHORTEST, drop_hallucination, is_same
from voice_assist.recognizer.scoring import ctc_likelihoods, decoder_likelihoods, ratios
from voice_assist.recognizer.verification import BLOCKS, PhraseVerifier
from voice_assist.recognizer.vocabulary import (
    END,
    NO_SPEECH,
    PROMPT,
    WHISPER_IDS,
    decode,
    encode,
    spelled,
)
from voice_assist.types import LONGEST, RATE, Hypothesis, IsHopeless, Samples, never_hopeless

EMBEDDING = "decoder.token_embedding.weight"
MIN_FRAMES = 40  # of the spectrogram; shorter sound gets quiet appended
MAX_ROUNDS = 16  # readings of a draft; each makes at least one more letter greedy
_AHEAD = 4  # letters that are read at least after those that are right
CTC_SHARE = 0.5  # of the CTC head in a score: a decoder soon takes a strange word for one it knows


@dataclass(frozen=True, eq=False)
class _Listened:
    """A sound, what the encoder made of it, and what the decoder has read so far."""

    sound: Samples
    hidden: Tensor  # after the lower blocks of the encoder, (1, time, d)
    states: Tensor  # (1, time, d)
    ctc: Tensor  # log-probabilities, (time, classes)
    draft: str
    memory: Memory  # of the states
    readings: dict[tuple[int, ...], Tensor] = field(default_factory=dict)  # by letters


class _Listening(nn.Module):
    """All that is made of a sound before the decoder reads it."""

    def __init__(self, network: WhisperCtc) -> None:
        super().__init__()
        self._network = network

    def forward(self, sound: Tensor) -> tuple[Tensor, ...]:
        """Of a sound, shape (1, n): hidden, states and ctc as `_Listened`, then the memory."""
        network = self._network
        hidden = encode_lower(network.whisper.encoder, log_mel(sound), BLOCKS)
        states = encode_upper(network.whisper.encoder, hidden, BLOCKS)
        return hidden, states, network.ctc_logprobs(states), *network.remember(states).values()


class EmbeddedRecognizer:
    """Greedy decoding by letters, with the CTC head's text as a draft.

    The decoder reads the draft, a command's length of it in one pass. Where it would have
    written another letter, the draft is corrected there and read again. The result is
    exactly that of greedy decoding, mostly for the price of one step. Only garbled
    talk needs more than MAX_ROUNDS readings: the rest of the draft then stands, so
    that no sound takes long. Every text shorter than MAX_ROUNDS letters, as all
    commands are, is exact. It stops earlier where the caller says that a text with
    such a beginning cannot matter.

    `model` holds the weights, for who adapts them; `network` is what listens.
    """

    def __init__(
        self,
        name: str,
        checkpoint: Checkpoint,
        device: str = "cpu",
        verifier: PhraseVerifier | None = None,
        dtype: torch.dtype | None = None,
    ) -> None:
        """Take the weights.

        Args:
            name: As asked for.
            checkpoint: With a CTC head.
            device: A torch device.
            verifier: Made for that checkpoint; None: no phrase is verified.
            dtype: Of its linear maps; None: the device's best.
        """
        self.name, self.model_hash = name, checkpoint.sha256
        self.model = restore(checkpoint).to(device).eval()
        self._dtype = dtype or dtype_for(device)
        self._device = device
        self._adapted()
        self._verifier = verifier

    def _adapted(self) -> None:
        """Listen by the weights that the model has now."""
        self.network = quick(self.model, self._dtype)
        example = torch.zeros(1, MIN_FRAMES * HOP_LENGTH, device=self._device)
        self._listening = in_one_call(_Listening(self.network), self._dtype, example)
        one_state = torch.zeros(1, 1, self.network.dims.n_audio_state, device=self._device)
        with torch.inference_mode():
            self._kept_by = list(self.network.remember(one_state))  # in the order of `_Listening`
        self._newest: _Listened | None = None  # another network's would be of other weights

    def transcribe(self, samples: Samples, is_hopeless: IsHopeless = never_hopeless) -> Hypothesis:
        """Text of the sound; see Recognizer."""
        if not is_audible(samples):
            return Hypothesis("", 0.0, 1.0)
        with torch.inference_mode():
            heard = self._listen(samples)
            return self._decode(heard, is_hopeless)

    def score(self, samples: Samples, phrases: Sequence[str]) -> dict[str, float]:
        """The decoder's and the CTC head's ratio, each to its own best other text, weighed.

        See Recognizer: where one is at most 0 for a phrase, the other has to make up for it.
        """
        if not is_audible(samples):
            return dict.fromkeys(phrases, float("-inf"))
        spelt = {phrase: spelled(phrase) for phrase in phrases}
        with torch.inference_mode():
            heard = self._listen(samples)
            written = self._decode(heard, never_hopeless).text
            texts = list(dict.fromkeys([*spelt.values(), "", heard.draft.strip(), written]))
            read = decoder_likelihoods(self.network, heard.states, texts).tolist()
            aligned = ctc_likelihoods(heard.ctc.cpu(), texts).tolist()
        decoder = ratios(dict(zip(texts, read, strict=True)), list(spelt.values()))
        head = ratios(dict(zip(texts, aligned, strict=True)), list(spelt.values()))
        share = CTC_SHARE
        return {p: (1.0 - share) * decoder[s] + share * head[s] for p, s in spelt.items()}

    def verify(self, samples: Samples, phrase: str) -> float:
        """The verifier's log-odds; see Recognizer."""
        if self._verifier is None:
            return float("inf")
        if not is_audible(samples):
            return float("-inf")
        with torch.inference_mode():
            heard = self._listen(samples)
            hidden, ctc = heard.hidden[0].cpu().numpy(), heard.ctc.cpu().numpy()
        return self._verifier(hidden, ctc, phrase)

    def _listen(self, samples: Samples) -> _Listened:
        """Encode a sound; the one that was just heard is not encoded again for its scores."""
        newest = self._newest
        if newest is not None and is_same(newest.sound, samples):
            return newest
        heard = np.array(samples[-int(LONGEST * RATE) :], dtype=np.float32)
        missing = MIN_FRAMES * HOP_LENGTH - len(heard)
        heard = np.pad(heard, (0, max(missing, 0)))
        sound = torch.from_numpy(heard)[None].to(self._device)
        hidden, states, ctc, *kept = self._listening(sound)
        draft = greedy_text(ctc[0].cpu().numpy())
        memory = dict(zip(self._kept_by, kept, strict=True))
        self._newest = _Listened(samples, hidden, states, ctc[0], draft, memory)
        return self._newest

    def _read(self, heard: _Listened, ids: Sequence[int]) -> Tensor:
        """Log-probabilities after each letter of the prompt and a text, (length, N_COMPACT)."""
        key = tuple(ids)
        if key not in heard.readings:
            tokens = torch.tensor([[*PROMPT, *ids]], device=self._device)
            logits = self.network.logits(tokens, heard.states, heard.memory)
            heard.readings[key] = logits[0].log_softmax(-1)
        return heard.readings[key]

    def _decode(self, heard: _Listened, is_hopeless: IsHopeless) -> Hypothesis:
        most = self.network.dims.n_text_ctx - len(PROMPT) - 1
        ids = encode(heard.draft)[:most]
        agreed = rounds = 0
        while True:
            first = ids[: _worth_reading(agreed)]
            logprobs = self._read(heard, first)
            written = logprobs[len(PROMPT) - 1 :]
            wanted = written.argmax(-1).tolist()
            agreed = _agreed(ids[: len(wanted)], wanted)
            if agreed > len(first):
                continue  # so far it is right, and there is more
            if wanted[agreed] == END or agreed == most:
                ids = ids[:agreed]
                break
            rounds += 1
            if rounds == MAX_ROUNDS:
                written = self._read(heard, ids)[len(PROMPT) - 1 :]
                break
            ids = [*ids[:agreed], wanted[agreed], *_rest(ids, agreed, wanted[agreed])][:most]
            if is_hopeless(decode(ids[: agreed + 1])):
                written = written[: agreed + 1]  # how sure it is of the letters that stand
                break
        read = [*ids, END][: len(written)]
        chosen = written[range(len(read)), read]
        no_speech = float(logprobs[0, NO_SPEECH].exp())
        return drop_hallucination(decode(ids).strip(), float(chosen.mean()), no_speech)


def restore(checkpoint: Checkpoint) -> WhisperCtc:
    """The compact model inside an exported checkpoint."""
    model = WhisperCtc(checkpoint.dims)
    unused = min(set(range(max(WHISPER_IDS))) - set(WHISPER_IDS))
    rows = checkpoint.state[EMBEDDING][[*WHISPER_IDS, unused]]
    state = {**checkpoint.state, EMBEDDING: rows}
    model.whisper.load_state_dict({name: weight.float() for name, weight in state.items()})
    head = checkpoint.ctc or {}
    model.ctc.load_state_dict({name: weight.float() for name, weight in head.items()})
    return model


def is_audible(samples: Samples) -> bool:
    """Whether there is enough sound to listen to at all."""
    return len(samples) >= SHORTEST * RATE and bool(np.any(samples))


def _worth_reading(agreed: int) -> int:
    """How many letters of a draft to read when so many are right: the rest may never matter."""
    rows = len(PROMPT) + agreed + _AHEAD
    return rows + -rows % STEP - len(PROMPT)


def _agreed(draft: list[int], wanted: list[int]) -> int:
    """Leading letters of the draft that the decoder writes too."""
    for index, letter in enumerate(draft):
        if letter != wanted[index]:
            return index
    return len(draft)


def _rest(draft: list[int], at: int, letter: int) -> list[int]:
    """What may follow in the draft once a letter is put in its place."""
    has_one_too_many = draft[at + 1 : at + 2] == [letter]
    return draft[at + 2 :] if has_one_too_many else draft[at + 1 :]

# SPDX-License-Identifier: BSD-3-Clause
"""Whisper's network with a small vocabulary and a CTC head on its encoder."""

from __future__ import annotations

import math

import torch
from torch import Tensor, nn
from torch.nn import functional
from whisper.model import AudioEncoder, ModelDimensions, Whisper

from voice_assist.recognizer.vocabulary import BLANK, GARBAGE, N_COMPACT, N_VOCAB

CONV1_GAIN, CONV2_GAIN = 8.0, 3.5  # sound about as loud as position after the convolutions


def encode_short(encoder: AudioEncoder, mel: Tensor) -> Tensor:
    """Whisper's encoder on as much sound as there is, without padding.

    Args:
        encoder: Of any Whisper model.
        mel: Log-mel spectrogram. Shape (batch, n_mels, frames), no more frames
            than twice the encoder's positions.

    Returns:
        Shape (batch, (frames + 1) // 2, d).
    """
    return encode_upper(encoder, encode_lower(encoder, mel, 0), 0)


def encode_lower(encoder: AudioEncoder, mel: Tensor, blocks: int) -> Tensor:
    """States after the first blocks of the encoder; arguments and shape as encode_short."""
    x = functional.gelu(encoder.conv1(mel))
    x = functional.gelu(encoder.conv2(x)).permute(0, 2, 1)
    x = x + encoder.positional_embedding[: x.shape[1]].to(x.dtype)
    for block in encoder.blocks[:blocks]:
        x = block(x)
    return x


def encode_upper(encoder: AudioEncoder, hidden: Tensor, blocks: int) -> Tensor:
    """The rest of the encoder, from the states after its first blocks."""
    for block in encoder.blocks[blocks:]:
        hidden = block(hidden)
    return encoder.ln_post(hidden)


Memory = dict[nn.Module | None, Tensor]  # by the linear map that made it


class WhisperCtc(nn.Module):
    """A Whisper of N_COMPACT tokens and a CTC head over characters.

    The last token stands for all of Whisper's tokens that are never used; its
    logit counts that often, so that softmax over the compact vocabulary equals
    softmax over the full one with the same row for each unused token.
    """

    def __init__(self, dims: ModelDimensions) -> None:
        """Build it untrained.

        Args:
            dims: Of the full model; n_vocab is replaced.
        """
        super().__init__()
        self.whisper = Whisper(ModelDimensions(**{**vars(dims), "n_vocab": N_COMPACT}))
        self.ctc = nn.Linear(dims.n_audio_state, BLANK + 1)
        offset = torch.zeros(N_COMPACT)
        offset[GARBAGE] = math.log(N_VOCAB - GARBAGE)
        self.register_buffer("offset", offset, persistent=False)

    @property
    def dims(self) -> ModelDimensions:
        """Sizes, with n_vocab of the compact vocabulary."""
        return self.whisper.dims

    def encode(self, mel: Tensor) -> Tensor:
        """Encoder states, shape (batch, (frames + 1) // 2, d)."""
        return encode_short(self.whisper.encoder, mel)

    def ctc_logprobs(self, states: Tensor) -> Tensor:
        """Log-probabilities of characters and blank, (batch, time, BLANK + 1)."""
        return self.ctc(states).float().log_softmax(-1)

    def remember(self, states: Tensor) -> Memory:
        """What the decoder's blocks keep of the states, for several readings of one sound."""
        before = torch.empty(1, 0)  # the decoder counts earlier tokens in the first entry
        memory: Memory = {None: before}
        for block in self.whisper.decoder.blocks:
            attention = block.cross_attn
            memory[attention.key] = attention.key(states)
            memory[attention.value] = attention.value(states)
        return memory

    def logits(self, tokens: Tensor, states: Tensor, memory: Memory | None = None) -> Tensor:
        """Decoder logits for compact tokens, shape (batch, length, N_COMPACT).

        Args:
            tokens: Compact ids. Shape (batch, length).
            states: Of the encoder. Shape (batch, time, d).
            memory: Of these states, if they are read more than once.
        """
        return self.whisper.decoder(tokens, states, kv_cache=memory).float() + self.offset

    def initialise(self) -> None:
        """Set what Whisper leaves unset or too large for training from nothing."""
        decoder = self.whisper.decoder
        width = self.dims.n_text_state
        nn.init.normal_(decoder.token_embedding.weight, std=width**-0.5)
        nn.init.normal_(decoder.positional_embedding, std=0.02)
        # Otherwise sound changes the encoder's input 30 times less than position does
        # (0.012 against 0.35, measured), and CTC learns nothing but letter frequencies.
        encoder = self.whisper.encoder
        with torch.no_grad():
            encoder.conv1.weight.mul_(CONV1_GAIN)
            encoder.conv2.weight.mul_(CONV2_GAIN)

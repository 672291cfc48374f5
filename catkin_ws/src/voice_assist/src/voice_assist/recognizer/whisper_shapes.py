# SPDX-License-Identifier: BSD-3-Clause
"""Sizes of Whisper's network, known before anything of it is built.

Names and shapes are those of `whisper.model.Whisper.state_dict()` (openai-whisper 20250625).
"""

from __future__ import annotations

from typing import Any

from whisper.model import ModelDimensions

from voice_assist.errors import ModelError

LIMITS = {  # the largest of OpenAI's models has 1280 states, 20 heads, 32 layers
    "n_mels": (80, 128),
    "n_audio_ctx": (1, 4096),
    "n_audio_state": (4, 4096),
    "n_audio_head": (1, 64),
    "n_audio_layer": (1, 64),
    "n_vocab": (51864, 51866),  # English only, multilingual, multilingual with Cantonese
    "n_text_ctx": (8, 4096),
    "n_text_state": (4, 4096),
    "n_text_head": (1, 64),
    "n_text_layer": (1, 64),
}
MELS = (80, 128)


def read_dims(what: str, dims: Any) -> ModelDimensions:
    """Sizes of a model out of its checkpoint.

    Raises:
        ModelError: One is missing, unknown, no whole number, or not of any Whisper.
    """
    if not isinstance(dims, dict) or dims.keys() != LIMITS.keys():
        given = ", ".join(map(str, dims)) if isinstance(dims, dict) else type(dims).__name__
        raise ModelError(f"{what}: dims has {given or 'no key'}, allowed: {', '.join(LIMITS)}")
    for key, (low, high) in LIMITS.items():
        value = dims[key]
        if not isinstance(value, int) or isinstance(value, bool) or not low <= value <= high:
            allowed = f"a whole number from {low} to {high}"
            raise ModelError(f"{what}: dims.{key} is {value!r:.80}, allowed: {allowed}")
    if dims["n_mels"] not in MELS:
        raise ModelError(f"{what}: dims.n_mels is {dims['n_mels']}, allowed: 80 or 128")
    for part in ("audio", "text"):
        state, heads = dims[f"n_{part}_state"], dims[f"n_{part}_head"]
        if state % heads or state % 2:
            allowed = f"an even multiple of its {heads} heads"
            raise ModelError(f"{what}: dims.n_{part}_state is {state}, allowed: {allowed}")
    if dims["n_text_state"] != dims["n_audio_state"]:
        allowed = f"as n_audio_state, {dims['n_audio_state']}"
        raise ModelError(f"{what}: dims.n_text_state is {dims['n_text_state']}, allowed: {allowed}")
    return ModelDimensions(**dims)


def whisper_shapes(dims: ModelDimensions) -> dict[str, tuple[int, ...]]:
    """Shape of every tensor of a Whisper model, by its name in a state dict."""
    width, text = dims.n_audio_state, dims.n_text_state
    shapes: dict[str, tuple[int, ...]] = {
        "encoder.positional_embedding": (dims.n_audio_ctx, width),
        "encoder.conv1.weight": (width, dims.n_mels, 3),
        "encoder.conv1.bias": (width,),
        "encoder.conv2.weight": (width, width, 3),
        "encoder.conv2.bias": (width,),
        "decoder.positional_embedding": (dims.n_text_ctx, text),
        "decoder.token_embedding.weight": (dims.n_vocab, text),
        **_norm("encoder.ln_post", width),
        **_norm("decoder.ln", text),
    }
    for layer in range(dims.n_audio_layer):
        shapes |= _block(f"encoder.blocks.{layer}", width, ("attn",))
    for layer in range(dims.n_text_layer):
        shapes |= _block(f"decoder.blocks.{layer}", text, ("attn", "cross_attn"))
    return shapes


def _block(name: str, width: int, attentions: tuple[str, ...]) -> dict[str, tuple[int, ...]]:
    shapes: dict[str, tuple[int, ...]] = {
        f"{name}.mlp.0.weight": (4 * width, width),
        f"{name}.mlp.0.bias": (4 * width,),
        f"{name}.mlp.2.weight": (width, 4 * width),
        f"{name}.mlp.2.bias": (width,),
        **_norm(f"{name}.mlp_ln", width),
    }
    for attention in attentions:
        shapes |= _norm(f"{name}.{attention}_ln", width)
        for part in ("query", "key", "value", "out"):
            shapes[f"{name}.{attention}.{part}.weight"] = (width, width)
            if part != "key":
                shapes[f"{name}.{attention}.{part}.bias"] = (width,)
    return shapes


def _norm(name: str, width: int) -> dict[str, tuple[int, ...]]:
    return {f"{name}.weight": (width,), f"{name}.bias": (width,)}

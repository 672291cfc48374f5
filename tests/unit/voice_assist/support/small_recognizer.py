# SPDX-License-Identifier: BSD-3-Clause
"""Recognisers that are small enough for tests, with weights drawn from a seed, and sounds."""

from dataclasses import replace
from functools import cache

import numpy as np
import torch
from whisper.model import ModelDimensions, Whisper

from voice_assist.recognizer.checkpoint import Checkpoint
from voice_assist.recognizer.hybrid import WhisperCtc
from voice_assist.recognizer.whisper_shapes import whisper_shapes
from voice_assist.training.data.noise import Surroundings, build_rooms
from voice_assist.training.data.synthesis import TrainingClip
from voice_assist.training.spotter.overlap_mixture import arrange

SMALL = ModelDimensions(80, 512, 32, 2, 2, 51864, 64, 32, 2, 1)
TINY = ModelDimensions(80, 512, 4, 2, 3, 51864, 64, 4, 2, 1)


def small_model(seed=0, dims=SMALL):
    torch.manual_seed(seed)
    made = WhisperCtc(dims)
    made.initialise()
    return made.eval()


def whisper_file(path, **dims):
    """Writes a file as OpenAI's are, and gives the model in it."""
    torch.manual_seed(0)
    whole = ModelDimensions(80, 1500, 32, 2, 2, 51864, 448, 32, 2, 1)
    made = Whisper(replace(whole, **dims)).eval()
    torch.nn.init.normal_(made.decoder.positional_embedding)  # Whisper leaves it unset
    torch.save({"dims": vars(made.dims), "model_state_dict": made.state_dict()}, path)
    return made


@cache
def tiny_checkpoint(sha256="0" * 64):
    """The encoder that a spotter over talk stands on."""
    draw = torch.Generator().manual_seed(0)
    shapes = whisper_shapes(TINY)
    state = {name: 0.1 * torch.randn(shape, generator=draw) for name, shape in shapes.items()}
    return Checkpoint(TINY, state, None, sha256)


def tone(frequency, seconds=0.4):
    time = np.arange(int(seconds * 16000)) / 16000
    return (8000 * np.sin(2 * np.pi * frequency * time)).astype(np.int16)


def spotter_material(frequency=1000):
    """People say the word at a pitch, beside other words and talk."""

    def said(**pitches):
        return [TrainingClip(tone(pitch), text, "word", "x") for text, pitch in pitches.items()]

    rooms = build_rooms((), np.random.default_rng(0), count=3)
    around = Surroundings((), rooms, (tone(200, 4.0), tone(300, 3.0)))
    word = said(stop=frequency)
    return arrange(word, word, said(up=3000, go=2500), said(top=2800), around)


def sound(seconds=1.0, seed=0):
    return np.random.default_rng(seed).normal(0, 0.05, int(seconds * 16000)).astype(np.float32)

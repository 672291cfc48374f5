# SPDX-License-Identifier: BSD-3-Clause
"""A recogniser that is small enough for tests of training, with weights drawn from a seed."""

import numpy as np
import torch
from whisper.model import ModelDimensions

from voice_assist.recognizer.hybrid import WhisperCtc

SMALL = ModelDimensions(80, 512, 32, 2, 2, 51864, 64, 32, 2, 1)


def small_model():
    torch.manual_seed(0)
    made = WhisperCtc(SMALL)
    made.initialise()
    return made.eval()


def sound(seconds=1.0, seed=0):
    return np.random.default_rng(seed).normal(0, 0.05, int(seconds * 16000)).astype(np.float32)

# SPDX-License-Identifier: BSD-3-Clause
"""A recogniser on another device than the CPU, such as cuda: no tensor is left behind on the CPU.

The device "meta" has no numbers, so it needs no GPU. A number that is read of it is ANY.
"""

import numpy as np
import pytest
import torch
from torch.utils._python_dispatch import TorchDispatchMode
from torch.utils._pytree import tree_leaves
from whisper.model import ModelDimensions, Whisper

from voice_assist.recognizer import load_recognizer
from voice_assist.recognizer.checkpoint import Checkpoint
from voice_assist.recognizer.embedded import EmbeddedRecognizer
from voice_assist.recognizer.verification import PhraseVerifier
from voice_assist.recognizer.vocabulary import BLANK
from voice_assist.recognizer.whisper import OpenAIRecognizer
from voice_assist.types import RATE, frozen_samples

DIMS = ModelDimensions(80, 600, 64, 1, 2, 51864, 64, 64, 1, 2)
PHRASES = ("stop", "tense", "pull more")
ACROSS = {"to", "_to_copy", "copy_", "index"}  # operations that may take tensors of two devices
READ = {"item", "is_nonzero", "_local_scalar_dense"}
ANY = 9  # longer than the prompt, where it stands for a text's end


class OneDevice(TorchDispatchMode):
    """Refuses, as cuda does, an operation on tensors of two devices; a single number may be any."""

    def __torch_dispatch__(self, operation, types, args=(), kwargs=None):
        kwargs = kwargs or {}
        leaves = tree_leaves((args, kwargs))
        tensors = [leaf for leaf in leaves if isinstance(leaf, torch.Tensor)]
        name = operation.__name__.split(".")[0]
        devices = {tensor.device for tensor in tensors if tensor.dim() > 0}
        if name not in ACROSS and len(devices) > 1:
            raise RuntimeError(f"{name} takes tensors of {devices}")
        if not tensors or not tensors[0].is_meta:
            return operation(*args, **kwargs)
        if name in READ:
            return ANY
        if name in ACROSS and torch.device("cpu") in leaves:
            return torch.zeros(tensors[0].shape, dtype=tensors[0].dtype)
        if name == "nonzero":  # how many there are depends on the numbers
            return tensors[0].new_zeros((1, tensors[0].dim()), dtype=torch.long)
        return operation(*args, **kwargs)


def checkpoint(ctc=None):
    torch.manual_seed(0)
    return Checkpoint(DIMS, Whisper(DIMS).state_dict(), ctc, "none")


def embedded(device):
    width = DIMS.n_audio_state
    ctc = {"weight": torch.zeros(BLANK + 1, width), "bias": torch.zeros(BLANK + 1)}
    return EmbeddedRecognizer("small", checkpoint(ctc), device, PhraseVerifier({}))


def openai(device):
    return OpenAIRecognizer("small", checkpoint(), device, max_tokens=8, dtype=torch.float32)


def noise():
    return frozen_samples(np.random.default_rng(3).normal(0, 0.1, RATE))


@pytest.mark.parametrize("load", [embedded, openai])
def test_no_operation_mixes_devices(load):
    recognizer, sound = load("meta"), noise()
    with OneDevice():
        recognizer.score(sound, PHRASES)  # transcribes it, too
        recognizer.verify(sound, "stop")


def test_what_mixes_devices_is_found():
    with OneDevice(), pytest.raises(RuntimeError, match="embedding takes tensors of"):
        torch.nn.Embedding(3, 4, device="meta")(torch.tensor([1]))


@pytest.mark.skipif(not torch.cuda.is_available(), reason="needs a GPU")
@pytest.mark.parametrize("load", [lambda device: load_recognizer(device=device), openai])
def test_on_a_gpu_the_same_is_heard(load):
    here, there, sound = load("cpu"), load("cuda"), noise()
    assert there.transcribe(sound).text == here.transcribe(sound).text
    expected = here.score(sound, PHRASES)
    assert there.score(sound, PHRASES) == pytest.approx(expected, abs=0.01)
    assert there.verify(sound, "tense") == pytest.approx(here.verify(sound, "tense"), abs=0.01)

# SPDX-License-Identifier: BSD-3-Clause
"""In which type of number a network computes: bfloat16 where the processor multiplies it."""

from __future__ import annotations

import copy
import warnings
from itertools import chain, pairwise
from typing import TypeVar

import torch
from torch import Tensor, nn
from torch.nn import functional

from voice_assist.config.voice import PRECISIONS
from voice_assist.errors import ModelError

AUTO, BFLOAT16, FLOAT32 = PRECISIONS
Network = TypeVar("Network", bound=nn.Module)

_ROWS = 128  # for which oneDNN lays weights out: 2.6 s of sound; others are as right
_FIRST = 2  # calls of a recorded network, in which it is made ready; each takes three times as long
STEP = 16  # rows; oneDNN compiles for each number of them anew, and keeps 200 MB if all occur


def dtype_for(device: str, precision: str = AUTO) -> torch.dtype:
    """Type of weights that a setting asks for; AUTO: the one in which the device is quickest.

    A processor with AVX-512 alone computes bfloat16 too, but step by step, and slower.

    Args:
        device: A torch device.
        precision: AUTO, or the name of a type.

    Raises:
        ModelError: The device does not multiply it.
    """
    has_it = torch.device(device).type == "cpu" and torch.cpu._is_avx512_bf16_supported()
    if precision == BFLOAT16 and not has_it:
        needed = "bfloat16 needs a processor with avx512_bf16"
        raise ModelError(f"precision {precision!r} on {device}: {needed}; allowed: auto, float32")
    return torch.bfloat16 if has_it and precision in (AUTO, BFLOAT16) else torch.float32


def quick(network: Network, dtype: torch.dtype) -> Network:
    """The same network for inference on the processor, its maps in another type.

    Linear maps and convolutions are most of the work. What is between them stays in float32, but
    for a GELU that follows one in a chain, which is computed with it. What differs then is measured
    by `python -m bench voice.precision`.

    Args:
        network: In float32. It shares all other weights with what is returned.
        dtype: Of weights and inputs of these maps, float32 or bfloat16.
    """
    if dtype == torch.float32:
        return network
    shared = {id(tensor): tensor for tensor in chain(network.parameters(), network.buffers())}
    twin = copy.deepcopy(network, shared)
    for module in list(twin.modules()):
        for name, child in list(module.named_children()):
            if isinstance(child, nn.Linear):
                setattr(module, name, _Linear(child.weight, child.bias, dtype))
            elif isinstance(child, nn.Conv1d):
                setattr(module, name, _Conv1d(child, dtype))
        if isinstance(module, nn.Sequential):
            _join(module)
    return twin


def in_one_call(network: nn.Module, dtype: torch.dtype, example: Tensor) -> nn.Module:
    """The same network, whose operations Python no longer calls one by one.

    Each call would give Python's lock to another thread of the node, and wait to get it back. The
    operations stay the same, and so does every bit of what they give. In bfloat16, and on another
    device than the processor, the network itself is returned. The maps in bfloat16 pad their rows
    by a count that a recorded call would keep.

    Args:
        network: In float32 or bfloat16, for inference; what it computes depends on tensors alone.
        dtype: What `quick` was given.
        example: An input; later ones may be longer or shorter, and more or fewer.
    """
    if dtype != torch.float32 or example.device.type != "cpu":
        return network
    with torch.inference_mode(), warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that shapes might be kept: tests compare other lengths
        recorded: nn.Module = torch.jit.trace(network, (example,), check_trace=False)
        for _ in range(_FIRST):
            recorded(example)
    return recorded


def _join(layers: nn.Sequential) -> None:
    """Have each GELU computed by the map before it."""
    for index, (layer, following) in enumerate(pairwise(layers)):
        if isinstance(following, nn.GELU) and isinstance(layer, _Linear):
            layer.after = "gelu"
            layers[index + 1] = nn.Identity()


class _Linear(nn.Module):
    """A linear map in another type, from and to float32, its weights as oneDNN wants them."""

    def __init__(self, weight: Tensor, bias: Tensor | None, dtype: torch.dtype) -> None:
        super().__init__()
        self.after = "none"  # what is computed with it, as oneDNN calls it
        self._dtype = dtype
        weight = weight.detach().to(dtype)
        self._weight = torch.ops.mkldnn._reorder_linear_weight(weight, _ROWS)
        self._bias = None if bias is None else bias.detach().to(dtype)

    def forward(self, x: Tensor) -> Tensor:
        """From shape (..., inputs) to (..., outputs)."""
        rows = x.flatten(0, -2).to(self._dtype)
        count = len(rows)
        if missing := -count % STEP:
            rows = functional.pad(rows, (0, 0, 0, missing))
        y: Tensor = torch.ops.mkldnn._linear_pointwise(
            rows, self._weight, self._bias, self.after, [], "none"
        )
        return y[:count].float().unflatten(0, x.shape[:-1])


class _Conv1d(_Linear):
    """A convolution as the linear map of what lies under its kernel, padded with zeros."""

    def __init__(self, layer: nn.Conv1d, dtype: torch.dtype) -> None:
        super().__init__(layer.weight.flatten(1), layer.bias, dtype)
        (self._width,), (self._stride,) = layer.kernel_size, layer.stride
        self._padding = int(layer.padding[0])

    def forward(self, x: Tensor) -> Tensor:
        """From shape (batch, channels, time) to (batch, channels, time)."""
        padded = functional.pad(x.to(self._dtype), (self._padding, self._padding))
        under = padded.unfold(2, self._width, self._stride)  # batch, channels, time, width
        return super().forward(under.transpose(1, 2).flatten(2)).transpose(1, 2)

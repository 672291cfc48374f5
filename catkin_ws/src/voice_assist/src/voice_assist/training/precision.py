# SPDX-License-Identifier: BSD-3-Clause
"""bfloat16 where the processor computes in it; elsewhere it is emulated, and fifty times slower."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import torch

FAST = frozenset(("avx512_bf16", "amx_bf16"))  # flags of /proc/cpuinfo


@cache
def has_bfloat16(cpuinfo: Path = Path("/proc/cpuinfo")) -> bool:
    """Whether the processor multiplies in bfloat16.

    Args:
        cpuinfo: Linux' description of the processors; false where there is none.
    """
    if not cpuinfo.is_file():
        return False
    return not FAST.isdisjoint(cpuinfo.read_text(encoding="utf-8").split())


def cheap_numbers(device: str = "cpu") -> torch.autocast:
    """A context in which networks compute in bfloat16 where that is fast.

    Args:
        device: Where they compute: "cpu", or another that torch knows and that is fast in it.
    """
    return torch.autocast(device, torch.bfloat16, enabled=device != "cpu" or has_bfloat16())

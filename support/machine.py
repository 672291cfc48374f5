# SPDX-License-Identifier: BSD-3-Clause
"""Whether this machine hears in real time while it simulates the robot too."""

from __future__ import annotations

import os
import time
from concurrent.futures import ThreadPoolExecutor
from typing import Final

ALLOWED: Final = 0.050  # [s] of a pass; while the robot moves there is one every 80 ms
_ROWS, _WIDTH, _WIDER, _MAPS = 80, 512, 2048, 24  # of the recogniser's encoder over 1.6 s of sound
_TRIES = 5


def hearing_obstacle() -> str:
    """Why words would be heard too late, or lost, on this machine at present; empty: it hears.

    It takes a second. No code of the product is timed, only arithmetic of its size.
    """
    return obstacle_of(pass_time())


def obstacle_of(seconds: float) -> str:
    """The same for a time of one pass [s]."""
    if seconds <= ALLOWED:
        return ""
    return (
        f"this machine is too slow to hear while it simulates the robot: arithmetic as of one pass "
        f"of the recogniser takes {seconds * 1e3:.0f} ms, allowed {ALLOWED * 1e3:.0f} ms"
    )


def pass_time() -> float:
    """Time of one pass on every core at once [s], the shortest of a few tries."""
    import torch

    has_bfloat16 = torch.cpu._is_avx512_bf16_supported()
    dtype = torch.bfloat16 if has_bfloat16 else torch.float32
    rows, weight = torch.ones(_ROWS, _WIDTH, dtype=dtype), torch.ones(_WIDER, _WIDTH, dtype=dtype)

    def one_pass(_: int) -> float:
        began = time.monotonic()
        for _ in range(_MAPS):
            torch.nn.functional.linear(rows, weight)
        return time.monotonic() - began

    def alone() -> None:
        torch.set_num_threads(1)  # counts for the thread that says so

    cores = len(os.sched_getaffinity(0))
    with ThreadPoolExecutor(cores, initializer=alone) as pool:
        return min(max(pool.map(one_pass, range(cores))) for _ in range(_TRIES))

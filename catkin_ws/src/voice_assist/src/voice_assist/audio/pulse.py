# SPDX-License-Identifier: BSD-3-Clause
"""Sources of a PulseAudio server, which PortAudio shows only as one device."""

from __future__ import annotations

import shutil
import subprocess
import threading
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from voice_assist.audio.source import FRAME
from voice_assist.types import RATE

_LATENCY_MS = 20  # [ms] asked of the server
PREFIX = "pulse:"  # of a microphone's name: pulse:<source>


def pulse_sources() -> tuple[str, ...]:
    """Names of the sources, the default one first; empty where no server or `pactl` answers."""
    rows = (line.split("\t") for line in _ask("list", "short", "sources"))
    names = [row[1] for row in rows if len(row) > 1]
    default = _ask("get-default-source")
    return tuple(sorted(names, key=lambda name: name not in default))


def _ask(*words: str) -> list[str]:
    """Lines that `pactl` answers."""
    program = shutil.which("pactl")
    if program is None:
        return []
    try:
        answer = subprocess.run([program, *words], capture_output=True, text=True, timeout=2.0)
    except subprocess.TimeoutExpired:
        return []
    return answer.stdout.splitlines()


class PulseStream:
    """Sound of one source, by `parec`; by way of PortAudio and ALSA it is 0.9 s late (measured)."""

    rate = RATE

    def __init__(self, source: str, on_block: Callable[[NDArray[np.int16], bool], None]) -> None:
        """Begin to record.

        Args:
            source: Name on the server.
            on_block: Takes each block of 32 ms, int16, 16 kHz, shape (512,), from a thread.

        Raises:
            OSError: `parec` is missing.
        """
        command = ["parec", "--raw", f"--device={source}", f"--latency-msec={_LATENCY_MS}"]
        command += [f"--rate={RATE}", "--channels=1", "--format=s16le"]
        self._recorder = subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, start_new_session=True
        )
        self._on_block = on_block
        self._thread = threading.Thread(target=self._read, name="parec", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """End the recording."""
        self._recorder.terminate()
        self._recorder.wait()
        self._thread.join()

    def _read(self) -> None:
        pipe = self._recorder.stdout
        while pipe is not None and len(block := pipe.read(2 * FRAME)) == 2 * FRAME:
            self._on_block(np.frombuffer(block, "<i2"), False)

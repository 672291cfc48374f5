# SPDX-License-Identifier: BSD-3-Clause
"""Sources of a PulseAudio server, which PortAudio shows only as one device."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import threading
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from voice_assist.audio.source import FRAME
from voice_assist.types import RATE

_LATENCY_MS = 20  # [ms] asked of the server
_CHECK_EVERY = 2.0  # [s] between checks that a source is still there
PREFIX = "pulse:"  # of a microphone's name: pulse:<source>
_MONITOR = re.compile(r"\.monitor(\.\d+)?$", re.IGNORECASE)  # the server's own ending of the name
_MOVED = "moved to device"  # how `parec` says that its sound now comes from elsewhere


def is_monitor(name: str) -> bool:
    """Whether a source gives what the machine itself plays, in place of a microphone's sound."""
    return _MONITOR.search(name) is not None


@dataclass(frozen=True)
class Source:
    """A source of the server."""

    name: str
    channels: int
    is_default: bool  # of the server, and no monitor


def pulse_sources() -> tuple[Source, ...]:
    """All sources; empty where no server or `pactl` answers."""
    rows = _listed()
    default = [name for name in _ask("get-default-source") if not is_monitor(name)]
    return tuple(Source(row[1], _channels(row[3]), row[1] in default) for row in rows)


def _listed() -> list[list[str]]:
    """Rows of the server's list of sources: number, name, module, sample specification."""
    rows = [line.split("\t") for line in _ask("list", "short", "sources")]
    return [row for row in rows if len(row) > 3]


def _channels(specification: str) -> int:
    """Of a sample specification such as `s16le 2ch 44100Hz`; 1 where it names none."""
    found = re.search(r"\b(\d+)ch\b", specification)
    return int(found.group(1)) if found else 1


def _ask(*words: str) -> list[str]:
    """Lines that `pactl` answers."""
    program = shutil.which("pactl")
    if program is None:
        return []
    try:
        answer = subprocess.run([program, *words], capture_output=True, timeout=2.0)
    except (OSError, subprocess.TimeoutExpired):
        return []
    return answer.stdout.decode(errors="replace").splitlines()


class PulseStream:
    """Sound of one source, by `parec`; by way of PortAudio and ALSA it is 0.9 s late (measured).

    A server moves a stream to another source when its own is unplugged. The sound ends then. It
    also ends once the server no longer lists the source.
    """

    rate = RATE

    def __init__(
        self, source: str, on_block: Callable[[NDArray[np.int16], bool], None], channels: int = 1
    ) -> None:
        """Begin to record.

        Args:
            source: Name on the server.
            on_block: Takes each block of 32 ms, int16, 16 kHz, shape (512, channels), from a
                thread.
            channels: Of the source; the server would give their mean, which may be silence.

        Raises:
            OSError: `parec` is missing.
        """
        command = ["parec", "--verbose", "--raw", f"--device={source}"]
        command += [f"--latency-msec={_LATENCY_MS}"]
        command += [f"--rate={RATE}", f"--channels={channels}", "--no-remap", "--format=s16le"]
        self._recorder = subprocess.Popen(
            command,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            process_group=0,  # not that of Ctrl-C; in the session, which is to hear first
            env={**os.environ, "LC_ALL": "C"},
        )
        self._source, self._on_block, self._channels = source, on_block, channels
        self._is_closed = threading.Event()
        targets = self._read, self._watch
        self._threads = [threading.Thread(target=target, daemon=True) for target in targets]
        for thread in self._threads:
            thread.start()
        threading.Thread(target=self._check, daemon=True).start()  # not joined: pactl may hang

    def close(self) -> None:
        """End the recording."""
        self._is_closed.set()
        self._recorder.terminate()
        self._recorder.wait()
        for thread in self._threads:
            thread.join()

    def _watch(self) -> None:
        """End the sound once the server takes it from another source."""
        pipe = self._recorder.stderr
        if pipe is None:
            return
        with open(pipe.fileno(), errors="replace", closefd=False) as lines:
            for line in lines:
                if _MOVED in line:
                    self._recorder.terminate()

    def _check(self) -> None:
        """End the sound once the server lists other sources only; no answer says nothing."""
        while not self._is_closed.wait(_CHECK_EVERY):
            names = [row[1] for row in _listed()]
            if names and self._source not in names:
                self._recorder.terminate()

    def _read(self) -> None:
        pipe, size = self._recorder.stdout, 2 * FRAME * self._channels
        while pipe is not None and len(block := pipe.read(size)) == size:
            self._on_block(np.frombuffer(block, "<i2").reshape(FRAME, self._channels), False)

# SPDX-License-Identifier: BSD-3-Clause
"""The theatre: noise without end, and phrases spoken into it, all on one virtual microphone."""

from __future__ import annotations

import os
import subprocess
import threading
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import soundfile

from demo.virtual_microphone import VirtualMicrophone
from paper.play.speaker import SpokenPhrase
from support.process_groups import start_group
from support.theatre_sound import LEVEL, RATE, theatre_noise

SINK = "surgeon"
LOOP = 60.0  # [s] of noise, then the same again; whole seconds, so that hum and beeps go on
AHEAD_MS = 400  # [ms] of sound held ready; with 30 a busy machine tears words apart (measured)
PLAYED_WITHIN = 20.0  # [s] longer than the longest phrase
_POLL = 0.01  # [s]


class PaperRoom:
    """A virtual microphone in a noisy room; context manager."""

    def __init__(self, snr_db: float, seed: int) -> None:
        """Prepare the noise.

        Args:
            snr_db: Of the speech over it [dB].
            seed: Of the noise.
        """
        self.microphone = VirtualMicrophone(SINK)
        noise = theatre_noise(LOOP, LEVEL * 10 ** (-snr_db / 20), seed)
        self._noise = np.round(noise * 32767).astype("<i2").tobytes()
        self._player: subprocess.Popen[bytes] | None = None

    def __enter__(self) -> PaperRoom:
        self.microphone.__enter__()
        command = ["pacat", "--playback", "--raw", f"--device={SINK}", f"--rate={RATE}"]
        command += ["--channels=1", "--format=s16le", f"--latency-msec={AHEAD_MS}"]
        self._player = start_group(
            command,
            stdin=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env={**os.environ, **self.microphone.environment},
        )
        threading.Thread(target=self._feed, args=(self._player,), daemon=True).start()
        return self

    def __exit__(self, *_: object) -> None:
        if self._player is not None:
            self._player.terminate()
            self._player.wait()
        self.microphone.__exit__()

    def say(
        self, spoken: SpokenPhrase, file: Path, begins: Callable[[], None]
    ) -> tuple[float, float]:
        """Play a phrase to its end.

        Args:
            spoken: The phrase.
            file: Where its sound is kept; WAV.
            begins: Called when the player has been started.

        Returns:
            When the player was started and when it ended [s]; it ends with its sound or after it.

        Raises:
            RuntimeError: The player or the noise has failed.
        """
        if self._player is None or self._player.poll() is not None:
            raise RuntimeError("the noise of the room has ended")
        soundfile.write(file, spoken.samples, RATE, subtype="PCM_16")
        began = time.time()
        player = self.microphone.play(file, AHEAD_MS)
        begins()
        while player.poll() is None and time.time() < began + PLAYED_WITHIN:
            time.sleep(_POLL)
        if player.poll() is None:
            player.kill()
        if player.wait():
            raise RuntimeError(f"{file.name} could not be played")
        return began, time.time()

    def _feed(self, player: subprocess.Popen[bytes]) -> None:
        """Write noise as fast as the player takes it, until it ends."""
        if player.stdin is None:
            return
        try:
            while True:
                player.stdin.write(self._noise)
        except OSError:
            return

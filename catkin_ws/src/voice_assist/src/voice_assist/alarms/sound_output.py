# SPDX-License-Identifier: BSD-3-Clause
"""Sound by `paplay` or `aplay`, each in a process of its own that can be ended when it is stuck."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Final

import numpy as np
import soundfile

from voice_assist.alarms.earcons import PATTERNS, samples_of
from voice_assist.alarms.types import Earcon
from voice_assist.config.alarms import SoundConfig
from voice_assist.errors import AudioError
from voice_assist.types import RATE

PULSE, ALSA = "pulse:", "alsa:"  # of a device's name
_POLL: Final = 0.02  # [s] between two checks of the program that plays
_TAIL: Final = 0.05  # [s] of silence after a sound, so that no device cuts its end


class ProgramOutput:
    """Plays through a program of the system, as a context: inside it the sounds lie in a folder.

    Args:
        config: Device, volume, and when a device counts as stuck.
        command: Program with its arguments; None: found by the device's name.
    """

    def __init__(self, config: SoundConfig, command: Sequence[str] | None = None) -> None:
        self._config, self._given = config, command
        self._folder: tempfile.TemporaryDirectory[str] | None = None

    def __enter__(self) -> ProgramOutput:
        self._folder = tempfile.TemporaryDirectory(prefix="voice_assist_alarms_")
        write_sounds(Path(self._folder.name), self._config.volume_db)
        return self

    def __exit__(self, *_: object) -> None:
        if self._folder is not None:
            self._folder.cleanup()
            self._folder = None

    def play(self, earcon: Earcon, is_cut: Callable[[], bool]) -> None:
        """Play to the end, or until `is_cut` says so.

        Raises:
            AudioError: There is no program, it fails, or it does not end in time.
        """
        if self._folder is None:
            raise AudioError("the sounds are not there; enter the output first")
        path = file_of(Path(self._folder.name), earcon)
        self.play_file(path, PATTERNS[earcon].duration, is_cut)

    def play_file(self, path: Path, duration: float, is_cut: Callable[[], bool]) -> None:
        """Play a sound file of a duration [s] to the end, or until `is_cut` says so.

        Raises:
            AudioError: There is no program, it fails, or it does not end in time.
        """
        command = self._given or player_command(self._config.device)
        process = subprocess.Popen(
            [*command, str(path)],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            start_new_session=True,
        )
        try:
            self._attend(process, duration + self._config.stuck_after, is_cut)
        finally:
            if process.poll() is None:
                process.kill()
            process.wait()
            if process.stderr is not None:
                process.stderr.close()

    def _attend(
        self, process: subprocess.Popen[bytes], allowed: float, is_cut: Callable[[], bool]
    ) -> None:
        until = time.monotonic() + allowed
        while process.poll() is None:
            if is_cut():
                return
            if time.monotonic() > until:
                raise AudioError(f"{self._name} does not end a sound within {allowed:.1f} s")
            time.sleep(_POLL)
        if process.returncode and process.stderr is not None:
            lines = process.stderr.read().decode(errors="replace").strip().splitlines()
            raise AudioError(f"{self._name}: {lines[0] if lines else process.returncode}")

    @property
    def _name(self) -> str:
        return f"sound device {self._config.device!r}" if self._config.device else "sound device"


def player_command(device: str) -> list[str]:
    """The program that plays a file on a device; the file's name is still to be added.

    Args:
        device: `pulse:<sink>`, `alsa:<device>`, or empty for the system's default.

    Raises:
        AudioError: The name is another, or the program is missing.
    """
    if device.startswith(ALSA):
        return [_program("aplay"), "-q", "-D", device.removeprefix(ALSA)]
    if device.startswith(PULSE):
        return [_program("paplay"), f"--device={device.removeprefix(PULSE)}"]
    if device:
        raise AudioError(
            f"sound device {device!r}, allowed: {PULSE}<sink>, {ALSA}<device>, or empty"
        )
    return [_program("paplay")] if shutil.which("paplay") else [_program("aplay"), "-q"]


def _program(name: str) -> str:
    found = shutil.which(name)
    if found is None:
        package = {"paplay": "pulseaudio-utils", "aplay": "alsa-utils"}[name]
        raise AudioError(f"{name} is missing; install {package}")
    return found


def write_sounds(folder: Path, volume_db: float) -> list[Path]:
    """Write every sound as a WAV file of 16 bit, 16 kHz; returns their paths."""
    paths = []
    for earcon in Earcon:
        sound = samples_of(earcon, volume_db)
        padded = np.concatenate([sound, np.zeros(round(_TAIL * RATE), np.float32)])
        path = file_of(folder, earcon)
        soundfile.write(str(path), padded, RATE, subtype="PCM_16")
        paths.append(path)
    return paths


def file_of(folder: Path, earcon: Earcon) -> Path:
    """Where the sound of an alarm lies in a folder."""
    return folder / f"{earcon.value}.wav"

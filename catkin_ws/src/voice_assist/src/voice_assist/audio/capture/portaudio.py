# SPDX-License-Identifier: BSD-3-Clause
"""The sound devices of this machine, through PortAudio; imported late, since it may be missing."""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from voice_assist.audio.capture.pulse import PREFIX, PulseStream, is_monitor, pulse_sources
from voice_assist.audio.source import FRAME
from voice_assist.errors import DeviceError
from voice_assist.types import RATE

_PULSE_LATENCY_MS = "20"  # else a PulseAudio server hands sound over in blocks of up to 2 s
_SERVERS = ("pulse", "pipewire")  # devices by which PortAudio shows a sound server
_MAX_CHANNELS = 8  # a device with more is one of software, which offers any number: 2 of it
_SLOT = re.compile(r" ?\(hw:\d+,\d+\)$|\.\d+(?=\.|$)")  # ALSA's, or a server's number of a twin
OnBlock = Callable[[NDArray[np.int16], bool], None]  # (n, channels), whether sound before was lost


@dataclass(frozen=True)
class Device:
    """A microphone that exists."""

    name: str
    rate: int  # [Hz] its own
    is_default: bool
    channels: int = 1

    @property
    def is_monitor(self) -> bool:
        """Whether it gives what the machine itself plays."""
        return is_monitor(self.name)


class Stream(Protocol):
    """An open microphone."""

    rate: int  # [Hz] of the blocks

    def close(self) -> None:
        """Stop the blocks; may be called twice."""
        ...


class Backend(Protocol):
    """Where microphones come from."""

    def devices(self) -> list[Device]:
        """All microphones, searched anew."""
        ...

    def open(self, device: Device, on_block: OnBlock) -> Stream:
        """Open one; `on_block` is called from a thread of the backend.

        Raises:
            DeviceError: It cannot be opened.
        """
        ...


class PortAudio:
    """Microphones through PortAudio, and the sources of PulseAudio by their names."""

    def __init__(self) -> None:
        """Load PortAudio.

        Raises:
            DeviceError: The library is not installed, or cannot start.
        """
        try:
            import sounddevice
        except OSError as error:
            raise DeviceError(f"PortAudio is missing ({error}); install libportaudio2") from error
        except Exception as error:  # the import starts PortAudio, whose error it then defines
            raise DeviceError(f"PortAudio cannot start ({error})") from error
        self._sd: Any = sounddevice
        os.environ.setdefault("PULSE_LATENCY_MSEC", _PULSE_LATENCY_MS)

    def devices(self) -> list[Device]:
        """All microphones; only while no stream is open, since PortAudio is started anew.

        Raises:
            DeviceError: PortAudio cannot search.
        """
        try:
            while self._sd._initialized:  # 0 after a start that failed, which ends nothing
                self._sd._terminate()
            self._sd._initialize()
            entries, default = list(self._sd.query_devices()), self._sd.default.device[0]
        except (self._sd.PortAudioError, ValueError) as error:  # or a name that is no text
            raise DeviceError(f"the sound devices cannot be searched ({error})") from error
        found = [
            Device(
                entry["name"],
                int(entry["default_samplerate"]),
                entry["index"] == default,
                _channels(entry["max_input_channels"]),
            )
            for entry in entries
            if entry["max_input_channels"] > 0
        ]
        sources = pulse_sources() if any(d.name in _SERVERS for d in found) else ()
        if sources:  # asked directly, the server is 0.9 s quicker than through ALSA
            found = [replace(device, is_default=False) for device in found]
        served = [Device(PREFIX + s.name, RATE, s.is_default, s.channels) for s in sources]
        return found + served

    def open(self, device: Device, on_block: OnBlock) -> Stream:
        """Open a microphone at 16 kHz, or at its own rate where it cannot do that."""
        name = device.name
        if name.startswith(PREFIX):
            try:
                return PulseStream(name[len(PREFIX) :], on_block, device.channels)
            except OSError as error:
                raise DeviceError(f"cannot be opened ({error})", name) from error
        problem: Exception | None = None
        for rate in (RATE, device.rate):  # many devices know only their own rate
            try:
                return _PortAudioStream(self._sd, device, rate, on_block)
            except (self._sd.PortAudioError, ValueError) as error:
                problem = error
        raise DeviceError(f"cannot be opened ({problem})", name) from problem


class _PortAudioStream:
    def __init__(self, sd: Any, device: Device, rate: int, on_block: OnBlock) -> None:
        self.rate = rate

        def enqueue(indata: NDArray[np.int16], frames: int, time: object, status: Any) -> None:
            on_block(indata.copy(), bool(status.input_overflow))

        self._stream = sd.InputStream(
            device=device.name,
            samplerate=rate,
            channels=device.channels,
            dtype="int16",
            blocksize=FRAME * rate // RATE,
            latency="low",
            callback=enqueue,
        )
        self._stream.start()

    def close(self) -> None:
        self._stream.close(ignore_errors=True)


def _channels(channels: int) -> int:
    return channels if channels <= _MAX_CHANNELS else 2


def has_twin(name: str, devices: list[Device]) -> bool:
    """Whether another microphone's name differs only by the slot, which changes when replugged.

    Args:
        name: The whole name of one.
        devices: Those that exist.
    """
    return any(d.name != name and _model(d.name) == _model(name) for d in devices)


def _model(name: str) -> str:
    return _SLOT.sub("", name)


def choose(name: str, devices: list[Device], is_whole: bool = False) -> Device:
    """The one microphone of that name; never another.

    The monitor of a loudspeaker is taken only by a name that ends as its own does.

    Args:
        name: The whole name, or a part of only one; empty for the system's default.
        devices: Those that exist.
        is_whole: A part does not do.

    Raises:
        DeviceError: None or several fit.
    """
    names = [device.name for device in devices]
    wanted = name.casefold()
    fitting = [device for device in devices if name and device.name.casefold() == wanted]
    if not fitting and not is_whole:
        able = [device for device in devices if is_monitor(name) or not device.is_monitor]
        fitting = [d for d in able if (wanted in d.name.casefold() if name else d.is_default)]
    if not fitting:
        raise DeviceError("not found", name, names)
    if len(fitting) > 1:
        some = ", ".join(repr(device.name) for device in fitting)
        raise DeviceError(f"the name fits several ({some})", name, names)
    return fitting[0]

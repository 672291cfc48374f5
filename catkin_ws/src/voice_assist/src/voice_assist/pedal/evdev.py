# SPDX-License-Identifier: BSD-3-Clause
"""Linux input devices (evdev): found by name, read without a library, for one reader."""

from __future__ import annotations

import errno
import fcntl
import os
import struct
from collections.abc import Collection, Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Final

NAMES: Final = Path("/sys/class/input")
DEVICES: Final = Path("/dev/input")
EVENT: Final = struct.Struct("llHHi")  # input_event: time, type, code, value
EV_SYN, EV_KEY, EV_ABS = 0, 1, 3
SYN_DROPPED: Final = 3  # code of EV_SYN: the kernel had no room for events
EVIOCGRAB: Final = 0x40044590  # a pedal is a keyboard: elsewhere it would type
KEYS: Final = 768  # codes of keys; the kernel gives a bit for each
EVIOCGKEY: Final = 2 << 30 | KEYS // 8 << 16 | 0x45 << 8 | 0x18  # which keys are pressed now
AXES: Final = 64  # codes of axes
EVIOCGBIT_KEY: Final = 2 << 30 | KEYS // 8 << 16 | 0x45 << 8 | 0x20 + EV_KEY  # keys that it has
EVIOCGBIT_ABS: Final = 2 << 30 | AXES // 8 << 16 | 0x45 << 8 | 0x20 + EV_ABS  # axes that it has
ABSINFO: Final = struct.Struct("6i")  # input_absinfo: value, and five more
EVIOCGABS: Final = 2 << 30 | ABSINFO.size << 16 | 0x45 << 8 | 0x40  # of axis 0: where it is now
NO_DEVICE: Final = (errno.ENOTTY, errno.EINVAL)  # it is a pipe of a test
REPEATED: Final = 2  # value of a key that is held


class DeviceMissingError(OSError):
    """No device has the name, or several have; names those that there are."""


def devices(names: Path = NAMES) -> dict[str, str]:
    """Name of each input device, by its event's name, such as event3."""
    found = {}
    for file in sorted(names.glob("event*/device/name")):
        with suppress(OSError, UnicodeDecodeError):
            found[file.parent.parent.name] = file.read_text(encoding="utf-8").strip()
    return found


def find(name: str, names: Path = NAMES) -> str:
    """The event's name of the one device of that name, or of which it is a part.

    Raises:
        DeviceMissingError: There is none, or more than one.
    """
    there = devices(names)
    exact = [event for event, its in there.items() if its == name]
    matching = exact or [event for event, its in there.items() if name in its]
    if len(matching) != 1:
        count = "no device" if not matching else f"{len(matching)} devices"
        listed = ", ".join(sorted(set(there.values()))) or "none"
        raise DeviceMissingError(f"{count} with {name!r} in the name; there are: {listed}")
    return matching[0]


class EventsLostError(OSError):
    """The kernel had no room for some events, so what is pressed is unknown."""


class EvdevReader:
    """One open device, as a context.

    Args:
        path: Of the device.
        inputs: Names of those that count, such as "axis 16".
    """

    def __init__(self, path: Path, inputs: Collection[str] = ()) -> None:
        self._path, self._inputs = path, inputs
        self._file = -1
        self.stamp = 0.0  # [s] clock time of the newest news; 0: it has none

    def __enter__(self) -> EvdevReader:
        """Open it.

        Raises:
            OSError: It cannot be opened, or another program reads it alone.
        """
        self._file = os.open(self._path, os.O_RDONLY | os.O_CLOEXEC)
        try:
            fcntl.ioctl(self._file, EVIOCGRAB, 1)
        except OSError as error:
            if error.errno not in NO_DEVICE:
                os.close(self._file)
                is_taken = error.errno == errno.EBUSY
                raise OSError("another program has taken it" if is_taken else error) from error
        return self

    def __exit__(self, *_: object) -> None:
        os.close(self._file)

    def __iter__(self) -> Iterator[Mapping[str, float]]:
        """First the state of its keys and axes, then news of inputs, until the device is gone.

        Raises:
            EventsLostError: Events were lost; opened again, it says what is pressed now.
            OSError: It is gone; says why.
        """
        if present := {**self._present_keys(), **self._present_axes()}:
            yield present
        rest = b""
        while data := os.read(self._file, 64 * EVENT.size):
            rest += data
            whole = len(rest) // EVENT.size * EVENT.size
            for seconds, micros, kind, code, value in EVENT.iter_unpack(rest[:whole]):
                self.stamp = seconds + micros / 1e6
                if kind == EV_KEY and value != REPEATED:
                    yield {f"button {code}": float(value)}
                elif kind == EV_ABS:
                    yield {f"axis {code}": float(value)}
                elif (kind, code) == (EV_SYN, SYN_DROPPED):
                    raise EventsLostError("events were lost, so what is pressed is unknown")
            rest = rest[whole:]
        raise DeviceMissingError("the device ends")

    def inputs(self) -> frozenset[str]:
        """Names of the keys and axes that it has."""
        keys = (f"button {code}" for code in self._codes(EVIOCGBIT_KEY, KEYS))
        axes = (f"axis {code}" for code in self._codes(EVIOCGBIT_ABS, AXES))
        return frozenset((*keys, *axes))

    def _codes(self, request: int, count: int) -> frozenset[int]:
        """Codes whose bits are set in the answer to a request."""
        try:
            bits = fcntl.ioctl(self._file, request, bytes(count // 8))
        except OSError:  # it is no device, but a pipe of a test
            return frozenset()
        return frozenset(code for code in range(count) if bits[code // 8] >> code % 8 & 1)

    def _present_keys(self) -> Mapping[str, float]:
        """Which of its keys are pressed; events report changes only."""
        pressed = self._codes(EVIOCGKEY, KEYS)
        has = sorted(self._codes(EVIOCGBIT_KEY, KEYS))
        return {f"button {code}": float(code in pressed) for code in has}

    def _present_axes(self) -> Mapping[str, float]:
        """Where the axes that count are; one that is unknown is left out."""
        found = {}
        for code in sorted(self._codes(EVIOCGBIT_ABS, AXES)):  # of others the kernel gives 0, too
            name = f"axis {code}"
            if name in self._inputs:
                with suppress(OSError):
                    data = fcntl.ioctl(self._file, EVIOCGABS + code, bytes(ABSINFO.size))
                    found[name] = float(ABSINFO.unpack(data)[0])
        return found

# SPDX-License-Identifier: BSD-3-Clause
"""A microphone by its name: a missing or lost one is reported and waited for, never replaced.

The settings may name a part of it, or leave it to the system's default. That counts until one is
opened. From then on only that one is opened, by its whole name, until a person chooses another. So
it is after a crash of the node, too. Two of one model cannot be told apart by their names: after a
loss, a person has to choose.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent.futures import Future
from dataclasses import dataclass, field
from queue import Empty, Full, Queue, SimpleQueue

import numpy as np
from numpy.typing import NDArray

from voice_assist.audio.capture.portaudio import Backend, Device, Stream, choose, has_twin
from voice_assist.audio.capture.pulse import is_monitor
from voice_assist.audio.resample import Resampler
from voice_assist.audio.source import MIN_GAP, Clock, Framer, Report
from voice_assist.config import MicrophoneConfig
from voice_assist.errors import DeviceError
from voice_assist.types import RATE, Frame

_QUEUE = 500  # blocks of 32 ms between the sound card's thread and the reader
_CHOICE_TIME = 6.0  # [s] in which a choice is taken up: one search for devices may take 2 s more
_TWIN = "was lost, and another of its model is or was there: choose one by set_microphone"
_OVERFLOW_GAP = 0.02  # [s] from which late sound after a reported overflow counts as lost

Pause = Callable[[float], bool]  # waits so many seconds; True: give up now


@dataclass(frozen=True)
class _Block:
    samples: NDArray[np.int16]  # (n,) or (n, channels)
    arrived: float  # [s] clock time
    is_after_loss: bool


@dataclass(frozen=True)
class _Choice:
    name: str
    answer: Future[str] = field(default_factory=Future)  # what is wrong; empty: nothing


class Microphone:
    """Frames from a microphone, as long as somebody reads them."""

    def __init__(
        self,
        config: MicrophoneConfig,
        backend: Backend,
        clock: Clock,
        pause: Pause,
        report: Report,
    ) -> None:
        """Remember which one.

        Args:
            config: Its name and what counts as lost.
            backend: Gives the devices.
            clock: For the stamps [s].
            pause: Waits between attempts, and says when to give up; `threading.Event.wait` does.
            report: Gets what is wrong; an empty text once it is right again.
        """
        self._config, self._backend, self._clock = config, backend, clock
        self._pause, self._report = pause, report
        self._queue: Queue[_Block] = Queue(_QUEUE)
        self._dropped = False
        self._stream: Stream | None = None
        self._framer = Framer()
        self._heard_until: float | None = None  # [s] end of the last block; None: none came yet
        self._choices: SimpleQueue[_Choice] = SimpleQueue()
        self._is_kept = config.is_whole  # the name is that of a device, and stays
        self._has_twin = False  # another of its model was there since it was opened
        self._was_left = False  # for a person's choice, and not lost
        self.remark = ""  # what a person should know of the channels; empty: nothing
        self.name = config.device  # asked for; once one was opened, that of this one

    @property
    def is_monitor(self) -> bool:
        """Whether it hears what the machine plays, which may be nothing for hours."""
        return is_monitor(self.name)

    def change(self, name: str) -> str:
        """Let frames come from another microphone from now on; for another thread than the reader.

        Args:
            name: As in the settings. Where none has it, the one before stays.

        Returns:
            What is wrong; empty: it exists and is opened now.
        """
        choice = _Choice(name)
        self._choices.put(choice)
        try:
            return choice.answer.result(_CHOICE_TIME)
        except TimeoutError:
            if choice.answer.cancel():
                return f"no answer within {_CHOICE_TIME:g} s; the microphone before stays"
            return choice.answer.result()

    def __enter__(self) -> Microphone:
        """Do nothing yet: the device is opened, and waited for, by reading."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close the device."""
        self._close()

    def __iter__(self) -> Iterator[Frame]:
        """Frames until `pause` says to give up; silent while the device is lost."""
        while True:
            try:
                device = self._open()
                yield from self._read(device)
                if self._choices.empty():
                    return
                self._was_left = True
            except DeviceError as error:
                self._close()
                self._report(str(error))
                if self._pause(self._config.retry_after):
                    return

    def _open(self) -> Device:
        self._close()
        devices = self._backend.devices()
        was_left, self._was_left = self._was_left, False
        before = self.name, self._is_kept
        self._has_twin |= self._is_kept and has_twin(self.name, devices)
        taken = self._take_choices(devices)
        device = choose(self.name, devices, is_whole=self._is_kept)
        if self._has_twin and not (taken or was_left):
            raise DeviceError(_TWIN, self.name, [d.name for d in devices])
        self._queue, self._dropped = Queue(_QUEUE), False
        try:
            self._stream = self._backend.open(device, self._enqueue)
        except DeviceError as error:
            self.name, self._is_kept = before
            self._was_left = was_left
            for choice in taken:
                choice.answer.set_result(str(error))
            raise
        self.name, self._is_kept = device.name, True
        self._has_twin = has_twin(device.name, devices)
        for choice in taken:
            choice.answer.set_result("")
        return device

    def _take_choices(self, devices: list[Device]) -> list[_Choice]:
        """Choices of devices that are there, still to be answered: the last is to be opened."""
        taken = []
        while not self._choices.empty():
            choice = self._choices.get()
            if not choice.answer.set_running_or_notify_cancel():
                continue  # the caller waits no longer, and was refused
            try:
                self.name, self._is_kept = choose(choice.name, devices).name, True
                taken.append(choice)
            except DeviceError as error:
                choice.answer.set_result(str(error))
        return taken

    def _close(self) -> None:
        if self._stream is not None:
            self._stream.close()
            self._stream = None

    def _enqueue(self, samples: NDArray[np.int16], is_after_loss: bool) -> None:
        """In the sound card's thread: only hand the block over."""
        try:
            block = _Block(samples, self._clock(), is_after_loss or self._dropped)
            self._queue.put_nowait(block)
            self._dropped = False
        except Full:
            self._dropped = True

    def _read(self, device: Device) -> Iterator[Frame]:
        """Frames until the device is lost, or another is chosen.

        Raises:
            DeviceError: It is lost.
        """
        if self._stream is None:
            raise DeviceError("not open", device.name)
        rate = self._stream.rate
        resample = Resampler(rate)
        expected: float | None = None  # [s] when the next block should begin
        while not self._pause(0.0) and self._choices.empty():
            block = self._next_block(device, is_first=expected is None)
            start = block.arrived - len(block.samples) / rate
            if expected is None:
                self._resume(start)
                expected = start
            late = start - expected
            if late > self._config.lost_after:
                raise DeviceError(f"gave no sound for {late:.1f} s", device.name, self._names())
            if block.is_after_loss and late > _OVERFLOW_GAP:
                self._framer.skip(round(late * RATE))
                expected = start
            # a slow clock drift follows the arrivals; single late blocks do not
            expected = expected + len(block.samples) / rate + 0.05 * (start - expected)
            self._heard_until = expected
            mono, self.remark = resample(block.samples), resample.remark
            yield from self._framer.push(mono, start)

    def _resume(self, start: float) -> None:
        """The first block of an opened device began at `start` [s]; what is missing is a gap."""
        if self._heard_until is not None:
            lost = round((start - self._heard_until) * RATE)
            self._framer.skip(max(lost, MIN_GAP))  # the clock may have been set back meanwhile
        self._report("")

    def _next_block(self, device: Device, is_first: bool) -> _Block:
        seconds = self._config.open_within if is_first else self._config.lost_after
        try:
            return self._queue.get(timeout=seconds)
        except Empty:
            problem = f"lost: no sound for {seconds:.1f} s"
            self._close()  # devices can only be searched anew while none is open
            raise DeviceError(problem, device.name, self._names()) from None

    def _names(self) -> list[str]:
        self._close()
        return [device.name for device in self._backend.devices()]

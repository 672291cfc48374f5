# SPDX-License-Identifier: BSD-3-Clause
"""Sound that comes as bytes without time or number: what it is, when it was, what is missing.

Bytes say nothing of their format. So what comes must last as long as it takes to come: compressed
sound, another rate or more channels do not, and are named instead of heard.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from voice_assist.audio.source import MIN_GAP
from voice_assist.config.voice import AudioDataConfig
from voice_assist.types import RATE

TYPES: Final = {"S16LE": "<i2", "S32LE": "<i4", "F32LE": "<f4"}
RAW: Final = ("", "wave", "pcm", "raw")  # codings that leave samples as they are
LONGEST: Final = 0.5  # [s] of sound in one message
GAP: Final = 0.25  # [s] that sound may be late before it counts as lost
FOLLOWS: Final = 0.05  # share of that lateness by which each message moves the expected time
DRIFT: Final = 1e-3  # of its length, at most: two clocks differ by less, so lost sound stays late
JUDGED_AFTER: Final = 1.0  # [s] of arrival from which the amount is judged
FORGOTTEN: Final = 5.0  # [s] of arrival that are judged at once
MIN_RATIO, MAX_RATIO = 0.8, 1.25  # sound that comes, in times real time


@dataclass(frozen=True, eq=False)
class SoundBlock:
    """Samples of one message."""

    samples: NDArray[np.generic]  # (n, channels), int16 or float in [-1, 1]
    stamp: float  # [s] of the first
    lost: float  # [s] of sound that is missing before it


class UnstampedStream:
    """Judges a stream, message by message.

    Args:
        config: Its format, as its publisher was set up.
    """

    def __init__(self, config: AudioDataConfig) -> None:
        self._config = config
        self._type = np.dtype(TYPES[config.sample_format])
        self._wrong_info = ""
        self._is_confirmed = False
        self._heard: float | None = None  # [s] clock time at which the last block was given
        self.forget()

    def forget(self) -> None:
        """Judge the format anew, as after a silence; what is missing until then stays a gap."""
        self._end: float | None = None  # [s] of the last sample
        self._arrived = 0.0  # [s] of the last message
        self._since, self._came = 0.0, 0.0  # [s] from when on is judged, sound since
        self._is_judged, self._is_resumed = False, True

    def inform(self, channels: int, rate: int, sample_format: str, coding_format: str) -> None:
        """Take what the publisher says of its format."""
        config = self._config
        found = f"{channels} x {rate} Hz {sample_format} {coding_format}".strip()
        wanted = f"{config.channels} x {config.rate} Hz {config.sample_format} wave"
        expected = config.channels, config.rate, config.sample_format
        is_same = (channels, rate, sample_format) == expected
        self._is_confirmed = is_same and coding_format.lower() in RAW
        self._wrong_info = "" if self._is_confirmed else f"sound is {found}, allowed: {wanted}"

    def take(self, data: bytes, now: float) -> SoundBlock | str:
        """Samples of a message, or why it is not heard; an empty text while that is not clear yet.

        Args:
            data: Of the message.
            now: Clock time at which it came [s].
        """
        if trouble := self._wrong_info or self._malformed(data):
            return f"{trouble}; it is not heard"
        config = self._config
        samples = np.frombuffer(data, self._type).reshape(-1, config.channels)
        duration = len(samples) / config.rate
        lost = self._lost(duration, now)
        if not self._is_confirmed:
            if trouble := self._misjudged(duration, now):
                return trouble
            if not self._is_judged:
                return ""
        if self._heard is not None:
            pause = now - duration - self._heard
            least = MIN_GAP / RATE if self._is_resumed else 0.0  # the clock may have been set back
            lost = max(lost, pause if pause > GAP else 0.0, least)
        self._heard, self._is_resumed = now, False
        return SoundBlock(_as_sound(samples), now - duration, lost)

    def _malformed(self, data: bytes) -> str:
        config, size = self._config, self._type.itemsize * self._config.channels
        if not data or len(data) % size:
            return f"{len(data)} bytes in a message, allowed: a multiple of {size}"
        seconds = len(data) / size / config.rate
        if seconds > LONGEST:
            return f"{seconds:.1f} s of sound in one message, allowed: {LONGEST:g} s"
        return ""

    def _lost(self, duration: float, now: float) -> float:
        """Sound that is missing before a message [s]; keeps up with the clock."""
        if self._end is None:
            self._end = self._since = self._arrived = now
            return 0.0
        due, pause = self._end + duration, now - self._arrived - duration
        late, self._arrived = now - due, now
        if pause > GAP:
            self._since += pause  # what did not come is no reason to doubt the format
        # a publisher's clock is a little off: followed slowly, it never adds up to a gap
        followed = min(FOLLOWS * late, DRIFT * duration)
        # no sound comes before it was made: what comes early shows that the expected time was late
        self._end = due + followed if 0.0 <= late <= GAP else now
        return late if late > GAP else 0.0

    def _misjudged(self, duration: float, now: float) -> str:
        """Why the amount of sound cannot be right; empty: it is, or it is too early to say."""
        elapsed = now - self._since
        if elapsed > 0.0:
            self._came += duration
        if elapsed < JUDGED_AFTER:
            return ""
        ratio = self._came / elapsed
        if elapsed > FORGOTTEN:
            self._since, self._came = now - 0.5 * elapsed, 0.5 * self._came
        self._is_judged = MIN_RATIO <= ratio <= MAX_RATIO
        if self._is_judged:
            return ""
        config = self._config
        form = f"{config.channels} x {config.rate} Hz {config.sample_format}"
        return (
            f"sound comes at {ratio:.2f} times real time if it is {form}, allowed: {MIN_RATIO:g} "
            f"to {MAX_RATIO:g}; is it compressed, or of another format? It is not heard"
        )


def _as_sound(samples: NDArray[np.generic]) -> NDArray[np.generic]:
    """Int16 as it is; other types as float32 in [-1, 1], where what is no number is silence."""
    if samples.dtype == np.int16:
        return samples
    if samples.dtype == np.int32:
        return (samples.astype(np.float64) / (1 << 31)).astype(np.float32)
    sound = samples.astype(np.float32)
    return np.clip(np.nan_to_num(sound, posinf=0.0, neginf=0.0), -1.0, 1.0)

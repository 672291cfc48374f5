# SPDX-License-Identifier: BSD-3-Clause
"""An audio topic in place of a microphone."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import suppress
from queue import Empty, Full, Queue

import rospy

from voice_assist.audio.capture.stamp_check import StampCheck
from voice_assist.audio.capture.unstamped import GAP
from voice_assist.audio.resample import Resampler
from voice_assist.audio.source import MIN_GAP, Framer, Report
from voice_assist.config import TopicConfig
from voice_assist.msg import AudioChunk
from voice_assist.ros.messages import pcm
from voice_assist.types import RATE, Frame

Subscribe = Callable[..., rospy.Subscriber]  # name, type and callback

_QUEUE = 1000  # chunks
_LONGEST = 0.5  # [s] of sound in one chunk
_RATES = range(8_000, 192_001)  # [Hz]
_EARLIEST, _LATEST = 1.0, 4e9  # [s] of a stamp; times computed from it must be valid stamps, too
_MAX_GAP = 3600.0  # [s] of lost sound between two chunks; a longer one is a restarted stream


class TopicSource:
    """Frames of a topic of AudioChunk, until the node shuts down."""

    remark = ""  # the sound of a topic has one channel

    def __init__(
        self,
        config: TopicConfig,
        report: Report,
        subscribe: Subscribe,
        report_clocks: Report | None = None,
    ) -> None:
        """Remember the topic.

        Args:
            config: Its name, and when it counts as silent.
            report: Called with what is wrong; with an empty text when all is well again.
            subscribe: Makes the subscriber, which takes the sound of believed nodes only.
            report_clocks: Called with how the stamps differ from this host's clock; with an empty
                text when they do not. None: the time of the sound does not matter.
        """
        self._config, self._report, self._subscribe = config, report, subscribe
        self._queue: Queue[AudioChunk | str] = Queue(_QUEUE)  # a text: why a chunk is not heard
        self._subscriber: rospy.Subscriber | None = None
        self._report_clocks, self._check_stamp = report_clocks, StampCheck()

    def __enter__(self) -> TopicSource:
        """Subscribe."""
        self._subscriber = self._subscribe(self._config.name, AudioChunk, self._enqueue)
        return self

    def __exit__(self, *_: object) -> None:
        """Unsubscribe."""
        if self._subscriber is not None:
            self._subscriber.unregister()

    def _enqueue(self, chunk: AudioChunk) -> None:
        duration = len(chunk.samples) / max(chunk.rate, 1)
        if chunk.header.stamp.is_zero():  # it ended when it came, near enough
            chunk.header.stamp = rospy.Time.from_sec(max(rospy.get_time() - duration, 0.0))
        chunk.samples = pcm(chunk)  # 2 bytes each while it waits, not 36
        trouble = _trouble(chunk)
        if not trouble:
            self._compare(chunk.header.stamp.to_sec() + duration)
        with suppress(Full):  # the reader notices the jump of first_sample
            self._queue.put_nowait(trouble or chunk)

    def _compare(self, end: float) -> None:
        """Compare the end of a chunk with this host's clock [s].

        A simulated clock is left out: it may be faster than the sound, or slower.
        """
        if self._report_clocks is not None and rospy.rostime.is_wallclock():
            self._report_clocks(self._check_stamp(end, rospy.get_time()))

    def __iter__(self) -> Iterator[Frame]:
        """Frames as they come; a jump of first_sample is kept as a gap."""
        framer, resample, rate = Framer(), Resampler(RATE), RATE
        expected, end = None, 0.0  # sample and stamp [s] that follow the last chunk
        while not rospy.is_shutdown():
            chunk = self._next()
            if chunk is None:
                continue
            if chunk.rate != rate:
                resample, rate = Resampler(chunk.rate), chunk.rate
            stamp, sound = chunk.header.stamp.to_sec(), pcm(chunk)
            if expected is not None:
                lost = chunk.first_sample - expected
                is_pause = stamp - end > GAP  # of a publisher that counts on over it
                if lost or is_pause:
                    seconds = min(max(lost / rate, stamp - end if is_pause else 0.0), _MAX_GAP)
                    framer.skip(max(round(seconds * RATE), MIN_GAP))
            expected, end = chunk.first_sample + len(sound), stamp + len(sound) / rate
            yield from framer.push(resample(sound), stamp)

    def _next(self) -> AudioChunk | None:
        try:
            chunk = self._queue.get(timeout=self._config.lost_after)
        except Empty:
            name = rospy.resolve_name(self._config.name)
            self._report(f"no sound on {name} for {self._config.lost_after:.1f} s")
            return None
        if isinstance(chunk, str):
            self._report(chunk)
            return None
        self._report("")
        return chunk


def _trouble(chunk: AudioChunk) -> str:
    """Why a chunk is no sound that can be heard; empty: it is."""
    if chunk.rate not in _RATES:
        allowed = f"{_RATES.start} to {_RATES.stop - 1} Hz"
        return f"sound at {chunk.rate} Hz, allowed: {allowed}; it is not heard"
    if len(chunk.samples) > _LONGEST * chunk.rate:
        seconds = len(chunk.samples) / chunk.rate
        return f"{seconds:.1f} s of sound in one message, allowed: {_LONGEST:g} s; it is not heard"
    stamp = chunk.header.stamp.to_sec()
    if not _EARLIEST <= stamp <= _LATEST:
        allowed = f"{_EARLIEST:g} to {_LATEST:g} s"
        return f"sound stamped with {stamp:.0f} s, allowed: {allowed}; it is not heard"
    return ""

# SPDX-License-Identifier: BSD-3-Clause
"""Sound of the audio_common package in place of a microphone."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import suppress
from queue import Empty, Full, Queue

import rospy
from audio_common_msgs.msg import AudioData, AudioInfo

from voice_assist.audio.capture.unstamped import SoundBlock, UnstampedStream
from voice_assist.audio.resample import Resampler
from voice_assist.audio.source import Framer, Report
from voice_assist.config.voice import AudioDataConfig
from voice_assist.ros.topic_source import Subscribe
from voice_assist.types import RATE, Frame

_QUEUE = 1000  # messages
_MAX_GAP = 3600.0  # [s] of lost sound; a longer one is a restarted stream


class AudioDataSource:
    """Frames of a topic of AudioData, until the node shuts down."""

    remark = ""

    def __init__(self, config: AudioDataConfig, report: Report, subscribe: Subscribe) -> None:
        """Remember the topics.

        Args:
            config: Their names, the format, and when the sound counts as gone.
            report: Called with what is wrong; with an empty text when all is well again.
            subscribe: Makes the subscribers, which take the sound of believed nodes only.
        """
        self._config, self._report, self._subscribe = config, report, subscribe
        self._queue: Queue[tuple[bytes, float] | AudioInfo] = Queue(_QUEUE)
        self._subscribers: list[rospy.Subscriber] = []
        self._silent_at = float("inf")  # [s] steady clock, from which without sound it is silent

    def __enter__(self) -> AudioDataSource:
        """Subscribe."""
        name, info = self._config.name, self._config.info
        self._subscribers = [self._subscribe(name, AudioData, self._enqueue)]
        if info:
            self._subscribers.append(self._subscribe(info, AudioInfo, self._keep))
        return self

    def __exit__(self, *_: object) -> None:
        """Unsubscribe."""
        for subscriber in self._subscribers:
            subscriber.unregister()

    def _enqueue(self, message: AudioData) -> None:
        self._keep((bytes(message.data), rospy.get_time()))

    def _keep(self, item: tuple[bytes, float] | AudioInfo) -> None:
        with suppress(Full):  # the stream falls behind its clock, and counts that as a gap
            self._queue.put_nowait(item)

    def __iter__(self) -> Iterator[Frame]:
        """Frames as they come; sound that is missing is kept as a gap."""
        stream = UnstampedStream(self._config)
        framer, resample = Framer(), Resampler(self._config.rate)
        self._wait_anew()
        while not rospy.is_shutdown():
            block = self._next(stream)
            if block is None:
                continue
            if block.lost:
                framer.skip(round(min(block.lost, _MAX_GAP) * RATE))
            yield from framer.push(resample(block.samples), block.stamp)

    def _next(self, stream: UnstampedStream) -> SoundBlock | None:
        try:
            item = self._queue.get(timeout=max(self._silent_at - time.monotonic(), 0.0))
        except Empty:
            self._wait_anew()
            stream.forget()
            self._report(self._silence())
            return None
        if isinstance(item, AudioInfo):
            stream.inform(item.channels, item.sample_rate, item.sample_format, item.coding_format)
            return None
        self._wait_anew()
        block = stream.take(*item)
        if isinstance(block, str):
            if block:
                self._report(block)
            return None
        self._report("")
        return block

    def _wait_anew(self) -> None:
        self._silent_at = time.monotonic() + self._config.lost_after

    def _silence(self) -> str:
        name = rospy.resolve_name(self._config.name)
        if self._subscribers[0].get_num_connections() == 0:
            return f"nobody publishes {name}"
        return f"no sound on {name} for {self._config.lost_after:.1f} s"

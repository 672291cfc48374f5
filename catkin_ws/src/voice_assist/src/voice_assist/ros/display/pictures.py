# SPDX-License-Identifier: BSD-3-Clause
"""Pictures of the scene: taken as they come, and asked for while somebody looks."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

import rospy
from sensor_msgs.msg import CompressedImage
from std_srvs.srv import Trigger

from typed_config.ros.service_calls import call_service
from voice_assist.config.display import PictureConfig
from voice_assist.display.theatre import Theatre
from voice_assist.ros.believed import Believed
from voice_assist.ros.display.messages import picture_kind

LARGEST = 8_000_000  # [B] of a picture
BUFFER = 16_000_000  # [B] of the connection: the newest picture is read whole
SMOOTHING = 0.2  # of the time between two pictures
PAUSE = 10.0  # periods between two pictures, from which on that was a pause
WITHIN = 10.0  # [s] for the service to answer; a busy host paints slowly


class Pictures:
    """Follows the topic; asks for the next picture in a thread of its own.

    Args:
        config: Topic, service and how often.
        theatre: Gets the pictures.
        is_watched: Whether anybody looks.
        known: Makes the subscriber, to those that are believed.
    """

    def __init__(
        self,
        config: PictureConfig,
        theatre: Theatre,
        is_watched: Callable[[], bool],
        known: Believed,
    ) -> None:
        self._config, self._theatre, self._is_watched = config, theatre, is_watched
        self._period = config.period
        self._last = float("-inf")
        self._was_pause = False  # before the last picture
        self._troubles: dict[str, str] = {}  # that were told, by what they are of
        theatre.see_picture_period(config.period)
        options = {"queue_size": 1, "buff_size": BUFFER}
        self._topic = known.hear(
            "camera", config.topic, CompressedImage, self._on_picture, **options
        )
        if config.request:
            threading.Thread(target=self._ask, name="pictures", daemon=True).start()

    def _on_picture(self, message: CompressedImage) -> None:
        kind, size = picture_kind(message.data), len(message.data)
        trouble = "" if kind else "a picture is neither PNG nor JPEG"
        if size > LARGEST:
            trouble = f"a picture is larger than the {LARGEST} bytes that are allowed"
        self._complain("picture", trouble, f" ({size} bytes)")
        if trouble:
            return
        self._learn_period(time.monotonic())
        self._theatre.see_picture_period(self._period)
        self._theatre.see_picture(kind, bytes(message.data), message.header.stamp.to_sec())

    def _learn_period(self, now: float) -> None:
        """Take in a picture at a time [s]; one pause says nothing, a second in a row does.

        A pause counts for `PAUSE` periods at most, and no period is below that of the settings.
        """
        interval, self._last, longest = now - self._last, now, PAUSE * self._period
        is_pause = longest <= interval < float("inf")  # there was none before the first picture
        if interval < longest or (is_pause and self._was_pause):
            self._period += SMOOTHING * (min(interval, longest) - self._period)
            self._period = max(self._period, self._config.period)
        self._was_pause = is_pause

    def _ask(self) -> None:
        """Ask again and again; a picture that takes long is asked for less often."""
        while not rospy.is_shutdown():
            began = time.monotonic()
            if self._is_watched():
                reply = call_service(self._config.request, Trigger, within=WITHIN)
                if (answer := reply.response) is not None:
                    self._complain("request", "" if answer.success else answer.message)
                elif reply.may_take_effect:  # else nobody offers any; the page says so
                    self._complain("request", reply.trouble)
            took = time.monotonic() - began
            rest = max(self._config.period - took, took / self._config.share - took)
            rospy.rostime.wallsleep(rest)

    def _complain(self, part: str, trouble: str, detail: str = "") -> None:
        """Log a trouble of a part once when it begins, whatever its detail; empty: it ended."""
        if trouble and trouble != self._troubles.get(part):
            rospy.logwarn("no picture of the scene: %s%s", trouble, detail)
        self._troubles[part] = trouble

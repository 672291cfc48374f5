# SPDX-License-Identifier: BSD-3-Clause
"""Pictures of the scene: single ones when asked for, or one after the other for a film."""

from __future__ import annotations

import io
import threading
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import rospy
from mcap.reader import make_reader
from mcap_ros1.decoder import DecoderFactory
from PIL import Image
from std_srvs.srv import Trigger

TOPIC = "/robot/scene/compressed"
WIDTH = 800  # [pixels] of the film
SPEED = 4.0  # times real time


def take_picture(complain: Callable[[str], None]) -> threading.Thread:
    """Ask the robot for a picture; rendering takes its time, so nobody waits for it."""

    def ask() -> None:
        try:
            reply = rospy.ServiceProxy("robot/snapshot", Trigger)()
        except rospy.ServiceException as error:
            complain(f"no picture: {error}")
            return
        if not reply.success:
            complain(f"no picture: {reply.message}")

    thread = threading.Thread(target=ask, daemon=True)
    thread.start()
    return thread


class Camera:
    """Takes picture after picture until it is closed."""

    def __init__(self, complain: Callable[[str], None]) -> None:
        self._closed = threading.Event()
        self._complain = complain
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Take no more."""
        self._closed.set()

    def _run(self) -> None:
        while not self._closed.is_set():
            take_picture(self._complain).join()


def write_film(mcap: Path, gif: Path) -> int:
    """Join the pictures of a recording to an animated GIF.

    Returns:
        Number of pictures.
    """
    stamps, frames = [], []
    with mcap.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        for _, _, message, picture in reader.iter_decoded_messages(topics=[TOPIC]):
            image = Image.open(io.BytesIO(picture.data)).convert("RGB")
            size = (WIDTH, round(image.height * WIDTH / image.width))
            frames.append(image.resize(size).quantize(64))
            stamps.append(message.log_time / 1e6)
    if len(frames) < 2:
        return len(frames)
    steps = [max((b - a) / SPEED, 20.0) for a, b in pairwise(stamps)]
    frames[0].save(
        gif,
        save_all=True,
        append_images=frames[1:],
        duration=[*steps, 1500.0],
        loop=0,
        optimize=True,
    )
    return len(frames)

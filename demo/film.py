# SPDX-License-Identifier: BSD-3-Clause
"""Pictures of the scene: single ones when asked for, or one after the other for a film.

`python -m demo.film SESSION` makes `film.gif` and, with sound, `film.mp4` of a session that was
recorded with `--film`; `make film` does both. The words that are said stand below the picture.
"""

from __future__ import annotations

import argparse
import io
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import rospy
from mcap.reader import make_reader
from mcap_ros1.decoder import DecoderFactory
from PIL import Image, ImageDraw, ImageFont
from std_srvs.srv import Trigger

from typed_config import newest_recording

TOPIC = "/robot/scene/compressed"
UTTERANCE, EVENT = "/voice_assist/utterance", "/rst_control/event"
DEVICE, SOUND = "/voice_assist/device", "/voice_assist/audio"
BAND = 52  # [pixels] below the picture, for the words
COLOURS = 200  # of a picture of the GIF; with fewer the small coloured parts turn grey
DARK, LIGHT = (24, 28, 36), (240, 240, 240)


@dataclass(frozen=True)
class FilmForm:
    """How a film looks."""

    width: int  # [pixels]
    rate: float  # [1/s] of pictures, at most
    speed: float  # times real time
    stays: float  # [s] of the session that words stand, unless others follow


GIF = FilmForm(width=560, rate=1.0, speed=4.0, stays=10.0)
VIDEO = FilmForm(width=960, rate=10.0, speed=1.0, stays=3.0)


@dataclass(frozen=True)
class Shot:
    """One picture of the session."""

    time: float  # [s] on the clock of the recording
    image: Image.Image


@dataclass(frozen=True)
class Caption:
    """Words below the picture."""

    time: float  # [s] on the clock of the recording
    words: str


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
    """Join the pictures of a recording, with what was said below them, to an animated GIF.

    Returns:
        Number of pictures; below two, nothing is written.
    """
    shots, captions = read_session(mcap)
    some = list(thinned(shots, GIF.rate))
    frames = [
        framed(shot.image, caption_at(captions, shot.time, GIF.stays), GIF.width).quantize(COLOURS)
        for shot in some
    ]
    if len(frames) < 2:
        return len(frames)
    steps = [max(1e3 * (b.time - a.time) / GIF.speed, 20.0) for a, b in pairwise(some)]
    frames[0].save(
        gif,
        save_all=True,
        append_images=frames[1:],
        duration=[*steps, 1500.0],
        loop=0,
        optimize=True,
    )
    return len(frames)


def read_session(mcap: Path) -> tuple[list[Shot], list[Caption]]:
    """Pictures and captions of a recording, each in order of time."""
    shots, captions = [], []
    topics = [TOPIC, UTTERANCE, EVENT, DEVICE]
    with mcap.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        for _, channel, message, content in reader.iter_decoded_messages(topics=topics):
            time = message.log_time / 1e9
            if channel.topic == TOPIC:
                image = Image.open(io.BytesIO(content.data)).convert("RGB")
                shots.append(Shot(time, image))
            elif words := caption_of(channel.topic, content):
                captions.append(Caption(time, words))
    return shots, captions


def caption_of(topic: str, content: object) -> str:
    """What stands below the picture because of a message; empty: nothing new."""
    if topic == UTTERANCE:
        taken = getattr(content, "command", "")
        said = f'"{getattr(content, "transcript", "")}"'
        return said if taken else f"{said}: no command"
    if topic == DEVICE:
        return f"{getattr(content, 'phrase', '')}: done" if getattr(content, "is_done", 0) else ""
    caller, command = getattr(content, "caller", ""), getattr(content, "command", "")
    is_by_voice = caller.endswith("/voice_assist")
    if getattr(content, "kind", "") != "accepted" or is_by_voice:
        return ""
    by = "by pedal" if caller.endswith("/pedal") else "by hand"
    return f"{by}: {command} ({getattr(content, 'message', '')})"


def caption_at(captions: Sequence[Caption], time: float, stays: float) -> str:
    """The newest words that still stand at a time [s], which is for `stays` [s]; empty: none."""
    known = [c for c in captions if c.time <= time < c.time + stays]
    return known[-1].words if known else ""


def thinned(shots: Sequence[Shot], rate: float) -> Iterator[Shot]:
    """At most so many pictures per second, the first among them."""
    after = float("-inf")
    for shot in shots:
        if shot.time >= after:
            yield shot
            after = shot.time + 1.0 / rate


def framed(image: Image.Image, words: str, width: int) -> Image.Image:
    """A picture of that width [pixels] with words in a band below it; its sides are even."""
    height = round(image.height * width / image.width)
    page = Image.new("RGB", (width, (height + BAND + 1) // 2 * 2), DARK)
    page.paste(image.resize((width, height)), (0, 0))
    font = ImageFont.load_default(size=20)
    pen = ImageDraw.Draw(page)
    while words and pen.textlength(words, font) > width - 24:
        words = words[:-2].rstrip(" .") + "…" if len(words) > 2 else ""
    pen.text((12, height + BAND // 2), words, LIGHT, font, anchor="lm")
    return page


def main(words: Sequence[str] | None = None) -> int:
    """Make both films of a session; returns the exit status."""
    parser = argparse.ArgumentParser(prog="demo.film", description=__doc__)
    parser.add_argument("session", type=Path, help="folder of the session")
    session = parser.parse_args(words).session
    recording = newest_recording(session)
    if recording is None:
        print(f"no session.mcap in {session}", file=sys.stderr)
        return 2
    from demo.video import write_video  # its encoder is a developer's package

    pictures = write_film(recording, session / "film.gif")
    if pictures < 2:
        print(f"no film.gif: {pictures} pictures in {recording}", file=sys.stderr)
        return 1
    print(f"{pictures} pictures in {session / 'film.gif'}")
    try:
        seconds = write_video(recording, session / "film.mp4")
    except RuntimeError as error:
        print(f"no film.mp4: {error}", file=sys.stderr)
        return 1
    print(f"{seconds:.0f} s with sound in {session / 'film.mp4'}")
    return 0


if __name__ == "__main__":
    sys.exit(main())

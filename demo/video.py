# SPDX-License-Identifier: BSD-3-Clause
"""The session as a video file with the sound that the voice node heard."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from itertools import chain
from pathlib import Path
from subprocess import PIPE, Popen
from tempfile import TemporaryDirectory, TemporaryFile

import numpy as np
import soundfile
from mcap.reader import make_reader
from mcap_ros1.decoder import DecoderFactory
from numpy.typing import NDArray
from PIL import Image

from demo.film import SOUND, VIDEO, Caption, Shot, caption_at, framed, read_session

LEAD = 1.0  # [s] before the first caption
LONGEST = 90.0  # [s]
MISSING = "no ffmpeg: pip install -r requirements-dev.txt (imageio-ffmpeg)"


def write_video(mcap: Path, file: Path) -> float:
    """Encode pictures, captions and sound of a recording.

    Returns:
        Length [s].

    Raises:
        RuntimeError: The encoder is missing, there are no pictures, or encoding fails.
    """
    program = encoder()
    shots, captions = read_session(mcap)
    if len(shots) < 2:
        raise RuntimeError(f"{len(shots)} pictures in {mcap}; record them with --film")
    begin = max(shots[0].time, (captions[0].time if captions else 0.0) - LEAD)
    length = min(shots[-1].time - begin, LONGEST)
    sound, rate = sound_of(mcap, begin, length)
    with TemporaryDirectory() as folder:
        wav = Path(folder) / "sound.wav"
        soundfile.write(wav, sound, rate, subtype="PCM_16")
        _encode(program, _frames(shots, captions, begin, length), wav, file)
    return length


def encoder() -> str:
    """Path of ffmpeg.

    Raises:
        RuntimeError: It is missing.
    """
    try:
        import imageio_ffmpeg
    except ImportError:
        raise RuntimeError(MISSING) from None
    return str(imageio_ffmpeg.get_ffmpeg_exe())


def sound_of(mcap: Path, begin: float, length: float) -> tuple[NDArray[np.int16], int]:
    """What the voice node heard from a time on [s], silence where nothing was recorded.

    Returns:
        Sound, shape (n,), and its rate [Hz].

    Raises:
        RuntimeError: No sound was recorded.
    """
    found: NDArray[np.int16] | None = None
    rate = 0
    with mcap.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        for _, _, _, chunk in reader.iter_decoded_messages(topics=[SOUND]):
            if found is None:
                rate = int(chunk.rate)
                found = np.zeros(round(length * rate), np.int16)
            samples = np.asarray(chunk.samples, np.int16)
            first = round((chunk.header.stamp.to_sec() - begin) * rate)
            skipped = max(-first, 0)
            place = found[max(first, 0) :][: max(len(samples) - skipped, 0)]
            place[:] = samples[skipped:][: len(place)]
    if found is None:
        raise RuntimeError(f"no sound in {mcap}")
    return found, rate


def _frames(
    shots: Sequence[Shot], captions: Sequence[Caption], begin: float, length: float
) -> Iterator[Image.Image]:
    """Pictures at the film's rate."""
    at, last = 0, ("", -1)
    for number in range(int(length * VIDEO.rate)):
        time = begin + number / VIDEO.rate
        while at + 1 < len(shots) and shots[at + 1].time <= time:
            at += 1
        if (words := caption_at(captions, time, VIDEO.stays), at) != last:
            last = words, at
            drawn = framed(shots[at].image, words, VIDEO.width)
        yield drawn


def _encode(program: str, frames: Iterator[Image.Image], wav: Path, file: Path) -> None:
    """Feed the encoder picture by picture: all of them would take a gigabyte."""
    first = next(frames)
    command = [
        *(program, "-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24"),
        *("-s", f"{first.width}x{first.height}", "-r", f"{VIDEO.rate:g}", "-i", "-"),
        *("-i", str(wav), "-c:v", "libx264", "-pix_fmt", "yuv420p", "-crf", "26"),
        *("-c:a", "aac", "-shortest", str(file)),
    ]
    with TemporaryFile() as said, Popen(command, stdin=PIPE, stderr=said) as process:
        assert process.stdin is not None
        with suppress(BrokenPipeError):  # it ended, and says why
            for frame in chain((first,), frames):
                process.stdin.write(frame.tobytes())
        with suppress(BrokenPipeError):
            process.stdin.close()
        process.wait()
        said.seek(0)
        words = said.read().decode("utf-8", "replace").strip()
    if process.returncode:
        raise RuntimeError(f"ffmpeg: {words[:300]}")

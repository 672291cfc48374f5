# SPDX-License-Identifier: BSD-3-Clause
"""Sound as broken microphones, cables, drivers and networks give it, from seeds."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import soxr
from numpy.typing import NDArray

from bench.voice.material import theatre_noise
from support.theatre_sound import speak
from voice_assist.audio.source import Framer
from voice_assist.types import RATE, Frame

Sound = NDArray[np.float64]
Block = tuple[Sound, int]  # samples, and how many are lost before them
Maker = Callable[[float, np.random.Generator], Iterator[Block]]
FULL = 32767

TALK = (  # none of it a command, or near one
    "they will bring the second set of instruments after the break",
    "could somebody turn the light a little to the left",
    "the pressure is one hundred and twenty over eighty",
    "we had the same patient here in the spring",
    "count the swabs again before we close",
    "she said that the meeting is at four o'clock",
    "is there more water in that bowl",
    "the camera is foggy, please wipe the lens",
    "I am going to have a look at the other side first",
    "nobody told me that the schedule had changed",
)
VOICES = ("en-us", "en-gb", "en-us+f3", "en-gb+m3", "en-gb-scotland", "en-029")


def talk(seconds: float, rng: np.random.Generator) -> Sound:
    """People who talk of other things, over the noise of a room. Shape (n,), peaks at about 0.5."""
    sound = 1e-3 * rng.standard_normal(round(seconds * RATE))
    at = int(rng.integers(RATE))
    while at < len(sound):
        voice = VOICES[int(rng.integers(len(VOICES)))]
        said = speak(TALK[int(rng.integers(len(TALK)))], voice, int(rng.integers(130, 190)))
        said = said[: len(sound) - at]
        sound[at : at + len(said)] += 0.5 * said / max(float(np.abs(said).max()), 0.1)
        at += len(said) + int(rng.uniform(0.3, 2.0) * RATE)
    return sound


def one_value(seconds: float, rng: np.random.Generator) -> Sound:
    """Zeros, or whatever a broken converter gives instead."""
    value = float(rng.choice([0.0, 0.0, rng.uniform(-1.0, 1.0), 1.0]))
    return np.full(round(seconds * RATE), value)


def deafening(seconds: float, rng: np.random.Generator) -> Sound:
    """120 dB where the microphone bears 80 to 100: noise, clipped almost all the time."""
    gain = 10 ** (rng.uniform(20.0, 40.0) / 20)
    return gain * rng.standard_normal(round(seconds * RATE))


def hum(seconds: float, rng: np.random.Generator) -> Sound:
    """A cable without its shield: the mains, far beyond full scale."""
    t = np.arange(round(seconds * RATE)) / RATE
    wave = np.sin(2 * np.pi * float(rng.choice([50.0, 60.0])) * t)
    return 10 ** (rng.uniform(6.0, 30.0) / 20) * wave + 0.01 * rng.standard_normal(len(t))


def random_bytes(seconds: float, rng: np.random.Generator) -> Sound:
    """No sound at all: bytes of something else."""
    return rng.integers(-FULL - 1, FULL + 1, round(seconds * RATE)) / FULL


def clipped(seconds: float, rng: np.random.Generator) -> Sound:
    """Talk 20 to 40 dB too loud."""
    return 10 ** (rng.uniform(20.0, 40.0) / 20) * talk(seconds, rng)


def wrong_rate(seconds: float, rng: np.random.Generator) -> Sound:
    """Talk at another rate than it is said to have: a half to three times as fast."""
    rate = float(rng.choice([8000, 11_025, 22_050, 24_000, 32_000, 44_100, 48_000]))
    said = talk(seconds * RATE / rate, rng)
    return np.asarray(soxr.resample(said, RATE, rate), float)


def byte_swapped(seconds: float, rng: np.random.Generator) -> Sound:
    """Talk whose bytes are in the wrong order, or one byte late."""
    words = np.rint(FULL * talk(seconds, rng)).astype("<i2")
    if rng.random() < 0.5:
        return words.astype(">i2").view("<i2").astype(float) / FULL
    shifted = words.tobytes()[1:] + b"\0"
    return np.frombuffer(shifted, "<i2").astype(float) / FULL


def crackle(seconds: float, rng: np.random.Generator) -> Sound:
    """Talk through a loose contact: spikes, and stretches in which it is off."""
    sound = talk(seconds, rng)
    spikes = rng.integers(len(sound), size=round(50 * seconds))
    sound[spikes] = rng.choice([-1.0, 1.0], len(spikes))
    for at in rng.integers(len(sound), size=round(2 * seconds)):
        sound[at : at + int(rng.uniform(0.002, 0.2) * RATE)] = 0.0
    return sound


def howling(seconds: float, rng: np.random.Generator) -> Sound:
    """The robot's own voice from a loudspeaker, which comes back until it howls."""
    sound = theatre_noise.make("replies", seconds, int(rng.integers(1 << 30))).astype(float)
    delay, gain = int(rng.uniform(0.02, 0.3) * RATE), rng.uniform(0.8, 1.05)
    for at in range(delay, len(sound), delay):
        before = sound[at - delay : at]
        stretch = sound[at : at + delay]
        stretch += np.clip(gain * before[: len(stretch)], -1.0, 1.0)
    t = np.arange(len(sound)) / RATE
    tone = np.sin(2 * np.pi * rng.uniform(300.0, 3000.0) * t) * np.clip(t / seconds, 0.0, 1.0)
    return sound + rng.uniform(0.0, 1.5) * tone


def whole(make: Callable[[float, np.random.Generator], Sound]) -> Maker:
    """As one block that loses nothing."""

    def blocks(seconds: float, rng: np.random.Generator) -> Iterator[Block]:
        yield make(seconds, rng), 0

    return blocks


def gaps(seconds: float, rng: np.random.Generator) -> Iterator[Block]:
    """Talk of which up to 0.4 s are lost, twice a second."""
    rest = talk(seconds, rng)
    lost = 0
    while len(rest):
        length = int(rng.uniform(0.1, 0.9) * RATE)
        yield rest[:length], lost
        lost = int(rng.uniform(0.001, 0.4) * RATE)
        rest = rest[length + lost :]


def stutter(seconds: float, rng: np.random.Generator) -> Iterator[Block]:
    """Talk in blocks of which some come twice, in the wrong order, or not at all."""
    size = int(rng.choice([160, 320, 512, 1024, 2048]))
    sound = talk(seconds, rng)
    pieces = [sound[at : at + size] for at in range(0, len(sound), size)]
    for i in np.flatnonzero(rng.random(len(pieces) - 1) < 0.15):
        pieces[i], pieces[i + 1] = pieces[i + 1], pieces[i]
    for i in np.flatnonzero(rng.random(len(pieces) - 1) < 0.15):
        pieces[i + 1] = pieces[i]
    for piece in pieces:
        yield piece, size if rng.random() < 0.05 else 0


KINDS: dict[str, Maker] = {
    "one value": whole(one_value),
    "deafening noise": whole(deafening),
    "hum": whole(hum),
    "random bytes": whole(random_bytes),
    "clipped talk": whole(clipped),
    "talk at a wrong rate": whole(wrong_rate),
    "talk with its bytes swapped": whole(byte_swapped),
    "talk with gaps": gaps,
    "talk that stutters": stutter,
    "talk through a loose contact": whole(crackle),
    "its own voice, howling": whole(howling),
}
DEAF = ("one value", "deafening noise", "hum", "random bytes")  # nobody would be heard in it


def frames(framer: Framer, blocks: Iterator[Block], stamp: float) -> Iterator[Frame]:
    """Blocks as a source would give them.

    Args:
        framer: Of the stream.
        blocks: Whatever is beyond full scale is clipped.
        stamp: Clock time of the first sample [s].
    """
    for samples, lost in blocks:
        framer.skip(lost)
        stamp += lost / RATE
        yield from framer.push(np.clip(samples, -1.0, 1.0), stamp)
        stamp += len(samples) / RATE

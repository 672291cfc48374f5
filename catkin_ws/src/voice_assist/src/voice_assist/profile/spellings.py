# SPDX-License-Identifier: BSD-3-Clause
"""Spellings learned from takes: what the recogniser writes when one person says a command.

So a phrase of any language can be a command. The recogniser knows English letters; for "mehr
ziehen" it writes something else, but for one person mostly the same, and that is compared.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from typed_config import items, text
from voice_assist.config.commands import CommandsConfig
from voice_assist.errors import CommandsError
from voice_assist.intent.confusability import objection
from voice_assist.profile.loudness import speech_of
from voice_assist.profile.manifest import read_part
from voice_assist.text.normalize import is_negated, normalize
from voice_assist.types import Samples

if TYPE_CHECKING:
    from voice_assist.recognizer.recognizer import Recognizer

NAME = "spellings.json"  # in a profile
MIN_LETTERS = 8  # of a spelling in all takes together: a short word has to come twice
MAX_SPELLINGS = 6  # spellings of one command
AROUND = 0.25  # [s] of quiet around the speech of a take


@dataclass(frozen=True, kw_only=True)
class Spelled:
    """What was learned of one command."""

    phrase: str = text()
    learned: tuple[str, ...] = text()


@dataclass(frozen=True, kw_only=True)
class Spellings:
    """All that a profile learned."""

    commands: tuple[Spelled, ...] = items(0, 200)


@dataclass(frozen=True)
class Refused:
    """A spelling that was not learned."""

    phrase: str
    spelling: str
    why: str


def learn_spellings(
    written: Mapping[str, Sequence[str]], commands: CommandsConfig
) -> tuple[Spellings, tuple[Refused, ...]]:
    """Choose spellings, the most frequent first.

    Args:
        written: Per command what the base recogniser wrote for each take of it.
        commands: That exist.

    Returns:
        What was learned, and what was not, with the reason.

    Raises:
        KeyError: A phrase is no command.
    """
    refused: list[Refused] = []
    found: dict[str, list[str]] = {phrase: [] for phrase in written}
    for phrase, spelling, count in _candidates(written):
        why = _too_rare(spelling, count) or _of_another(phrase, spelling, written)
        if not why and len(found[phrase]) >= MAX_SPELLINGS:
            why = f"{MAX_SPELLINGS} others are more frequent"
        if not why:
            why = _why_not(commands, phrase, spelling)
        if why:
            refused.append(Refused(phrase, spelling, why))
            continue
        command = commands.get(phrase)
        if spelling not in [" ".join(normalize(words)) for _, words in command.all_spellings]:
            found[phrase].append(spelling)
            commands = _with(commands, phrase, (*command.learned, spelling))
    learned = (Spelled(phrase=p, learned=tuple(s)) for p, s in found.items() if s)
    return Spellings(commands=tuple(learned)), tuple(refused)


def hear_spellings(
    takes: Iterable[tuple[str, Samples]], recognizer: Recognizer, commands: CommandsConfig
) -> tuple[Spellings, tuple[Refused, ...]]:
    """Learn from takes, as a recogniser writes them; none of a command that is no more.

    Args:
        takes: Phrase and sound of each. Shape (n,), 16 kHz.
        recognizer: As it will hear the person: with the adapted weights, where there are some.
        commands: That exist.

    Returns:
        What was learned, and what was not, with the reason.
    """
    written: dict[str, list[str]] = {}
    for phrase, samples in takes:
        if phrase not in commands.phrases:
            continue
        heard = recognizer.transcribe(speech_of(samples, AROUND))
        written.setdefault(phrase, []).append(heard.text)
    return learn_spellings(written, commands)


def overlay(commands: CommandsConfig, spellings: Spellings) -> CommandsConfig:
    """The commands with what a profile learned; of commands that are no more nothing is taken.

    Raises:
        CommandsError: Commands have come since that a spelling is too near to.
    """
    for spelled in spellings.commands:
        if spelled.phrase in commands.phrases:
            commands = _with(commands, spelled.phrase, spelled.learned)
    return commands


def from_bytes(data: bytes) -> Spellings:
    """What `manifest.to_bytes` gave.

    Raises:
        VoiceError: It is something else.
    """
    return read_part(Spellings, data, NAME)


def _candidates(written: Mapping[str, Sequence[str]]) -> list[tuple[str, str, int]]:
    """Command, spelling and how often it was written; the most frequent first."""
    counts = [
        (phrase, " ".join(words), count)
        for phrase, texts in written.items()
        for words, count in Counter(normalize(text) for text in texts).items()
        if words
    ]
    return sorted(counts, key=lambda found: (-found[2], found[0], found[1]))


def _too_rare(spelling: str, count: int) -> str:
    letters = count * len(spelling.replace(" ", ""))
    allowed = f"allowed: {MIN_LETTERS} letters in all takes together, and more"
    rare = f"written {count} times with {letters} letters, {allowed}"
    return "" if letters >= MIN_LETTERS else rare


def _of_another(phrase: str, spelling: str, written: Mapping[str, Sequence[str]]) -> str:
    words = tuple(spelling.split())
    for other, texts in written.items():
        if other != phrase and words in [normalize(text) for text in texts]:
            return f"it was written for {other!r}, too"
    return ""


def _why_not(commands: CommandsConfig, phrase: str, spelling: str) -> str:
    """Why a spelling would not do beside all others; empty: it would."""
    command = commands.get(phrase)
    if is_negated(tuple(spelling.split())) and not command.is_halt:
        return "it denies; what is denied never moves"
    if why := objection(spelling, commands, phrase):
        return why
    try:
        _with(commands, phrase, (*command.learned, spelling))
    except CommandsError as error:
        return str(error)
    return ""


def _with(commands: CommandsConfig, phrase: str, learned: tuple[str, ...]) -> CommandsConfig:
    changed = (replace(c, learned=learned) if c.phrase == phrase else c for c in commands.commands)
    return replace(commands, commands=tuple(changed))

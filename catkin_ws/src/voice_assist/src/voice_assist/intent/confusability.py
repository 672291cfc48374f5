# SPDX-License-Identifier: BSD-3-Clause
"""Warns of phrases too alike, in sound and in spelling, before anybody relies on them.

Chosen by measurement: of 114 near misses of the seven commands that were synthesised in several
voices, those that the recogniser ever took for a command (`bench/results/voice/near.json`) are, but
for one, nearer than ALIKE in sound, and two thirds of them are nearer than TOO_ALIKE. The nearest
two of the seven commands themselves, "pull more" and "pull less", are 0.38 apart.

Commands with an amount have most words in common, and nothing forgives a number. So of these only
the words by which two differ are compared: the numbers of a slot, and the words beside an amount.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import combinations, product
from typing import Final, Literal

from voice_assist.config.commands import AmountCommand, CommandConfig, CommandsConfig
from voice_assist.text.amounts import UNITS
from voice_assist.text.normalize import normalize
from voice_assist.text.phonetic_distance import can_pronounce, can_read, distance, sounds
from voice_assist.text.wer import distance as edits
from voice_assist.text.wer import wer

Verdict = Literal["too alike", "alike", "apart"]

TOO_ALIKE: Final = 0.20  # distance in sound, below which two commands may not stand side by side
ALIKE: Final = 0.33  # below it, and in spelling, there is a warning
TOO_ALIKE_LETTERS: Final = 0.10  # of the letters differ, and not more
ENGLISH: Final = "en-us"
_SHOWN: Final = 12  # pairs in a report


@dataclass(frozen=True)
class CommandPair:
    """Two commands by those of their spellings that are most alike."""

    one: str  # command
    other: str  # command
    spellings: tuple[str, str]  # of each
    sound: float  # distance of their sounds, 0 to 1
    letters: float  # characters to change, per character of the longer spelling (CER)
    wer: float  # the smaller of their two

    @property
    def verdict(self) -> Verdict:
        """Whether they differ enough."""
        if self.sound < TOO_ALIKE or self.letters < TOO_ALIKE_LETTERS:
            return "too alike"
        return "alike" if min(self.sound, self.letters) < ALIKE else "apart"

    @property
    def words(self) -> str:
        """The pair with its distances, for people."""
        (a, b), limit = self.spellings, TOO_ALIKE if self.verdict == "too alike" else ALIKE
        return (
            f"{a!r} and {b!r} ({self.other}) are {self.verdict}: {self.sound:.2f} apart in sound, "
            f"{self.letters:.2f} in letters, allowed: {limit:.2f} and more"
        )


def closest_pairs(commands: CommandsConfig, language: str = ENGLISH) -> list[CommandPair]:
    """Every two commands by their most alike spellings, the most alike first.

    Args:
        commands: That have to differ.
        language: In which espeak-ng pronounces them.
    """
    fixed = {c.phrase: _spellings(c) for c in commands.commands if not _has_amount(c)}
    found = [
        min(_pairs(one, fixed[one], other, fixed[other], language), key=_alikeness)
        for one, other in combinations(fixed, 2)
    ]
    found += [_differing(*pair, language) for pair in _pairs_of_amounts(commands)]
    return sorted(found, key=_alikeness)


def nearest(text: str, commands: CommandsConfig, own: str = "") -> CommandPair | None:
    """What a new phrase or spelling is most like among the commands that exist.

    Args:
        text: The new phrase or spelling.
        commands: Those that exist.
        own: The command that it is to belong to, which it may be like; empty: a new one.

    Returns:
        The most alike pair; None where there is no other command.
    """
    pairs = [
        pair
        for command in commands.commands
        if command.phrase != own and not _has_amount(command)
        for pair in _pairs(own or text, (text,), command.phrase, _spellings(command), ENGLISH)
    ]
    return min(pairs, key=_alikeness, default=None)


def objection(text: str, commands: CommandsConfig, own: str = "") -> str:
    """Why a new phrase or spelling may not be added; empty: it may. See `nearest`."""
    pair = nearest(text, commands, own)
    return pair.words if pair is not None and pair.verdict == "too alike" else ""


def report_lines(pairs: Iterable[CommandPair]) -> Iterator[str]:
    """Lines that show the most alike pairs, and the verdict over all of them."""
    pairs = list(pairs)
    if not can_pronounce():
        yield "espeak-ng is not installed: sounds are guessed from letters"
    yield f"{'sound':>6} {'CER':>5} {'WER':>5}"
    for pair in pairs[:_SHOWN]:
        a, b = pair.spellings
        numbers = f"{pair.sound:6.2f} {pair.letters:5.2f} {pair.wer:5.2f}"
        yield f"{numbers}  {pair.verdict:9}  {a!r} and {b!r}"
    worst = {"too alike": 0, "alike": 0, "apart": 0}
    for pair in pairs:
        worst[pair.verdict] += 1
    yield (
        f"{len(pairs)} pairs of commands: {worst['too alike']} too alike (below {TOO_ALIKE:.2f}), "
        f"{worst['alike']} alike (below {ALIKE:.2f}), {worst['apart']} apart"
    )


def _has_amount(command: CommandConfig) -> bool:
    return isinstance(command, AmountCommand)


def _pairs_of_amounts(commands: CommandsConfig) -> Iterator[tuple[str, str]]:
    """What may be taken for each other where commands have amounts: numbers, and what is beside."""
    with_amount = [c for c in commands.commands if isinstance(c, AmountCommand)]
    beside = dict.fromkeys(
        c.template.replace(f"{{{c.slot.name}}}", UNITS[c.slot.unit][1]) for c in with_amount
    )
    yield from combinations(beside, 2)
    yield from product(beside, commands.fixed_phrases)
    for slot in {c.slot.name: c.slot for c in with_amount}.values():
        yield from combinations((slot.number(value) for value in slot.values), 2)


def _differing(one: str, other: str, language: str) -> CommandPair:
    """Two texts by the words that they have not in common at their beginning and end."""
    a, b = one.split(), other.split()
    while a and b and a[0] == b[0]:
        del a[0], b[0]
    while a and b and a[-1] == b[-1]:
        del a[-1], b[-1]
    (pair,) = _pairs(one, (" ".join(a),), other, (" ".join(b),), language)
    return replace(pair, spellings=(one, other))


def _spellings(command: CommandConfig) -> tuple[str, ...]:
    """What is compared: of a halt no sentences around its word, since hearing one errs safely.

    A text that nothing reads aloud is left out, since it has no sounds.
    """
    spellings = tuple(text for _, text in command.all_spellings if can_read(text))
    if not command.is_halt:
        return spellings
    own = set(normalize(command.phrase))
    return (command.phrase, *(s for s in spellings if not own <= set(normalize(s))))


def _pairs(
    one: str, spellings: Iterable[str], other: str, others: Iterable[str], language: str
) -> Iterator[CommandPair]:
    theirs = [(b, normalize(b), sounds(b, language)) for b in others]
    for a in spellings:
        words, said = normalize(a), sounds(a, language)
        for b, their_words, their_sounds in theirs:
            x, y = " ".join(words), " ".join(their_words)
            yield CommandPair(
                one,
                other,
                (a, b),
                distance(said, their_sounds),
                edits(x, y) / max(len(x), len(y), 1),
                min(wer(words, their_words), wer(their_words, words)),
            )


def _alikeness(pair: CommandPair) -> tuple[float, float]:
    return min(pair.sound, pair.letters), pair.sound

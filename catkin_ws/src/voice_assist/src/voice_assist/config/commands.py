# SPDX-License-Identifier: BSD-3-Clause
"""commands.yaml: what can be said, and the rules that the commands keep among themselves."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields
from typing import ClassVar

from typed_config import choice, flag, items, number, text
from voice_assist.config.spelling_grammar import SlotConfig, slot_of, without_brackets
from voice_assist.errors import CommandsError
from voice_assist.text.amounts import amount_words, with_value
from voice_assist.text.normalize import Words, is_negated, normalize
from voice_assist.text.phonetic_distance import can_read
from voice_assist.text.wer import wer

# The robot's commands that begin no motion.
NOT_MOTIONS = ("hey robot", "stop", "terminate", "grasp here")
ENGLISH = "en"
LANGUAGES = (ENGLISH, "de", "es", "fr", "ja")  # of the commands, as Whisper names them
MEASURE_BACKGROUND = "python -m voice_assist.training.phrase_background"
NEVER_SURE = 0.95  # [0, 1] a recogniser is hardly ever surer of a word than this


@dataclass(frozen=True, kw_only=True)
class CommandConfig:
    """One spoken command."""

    RENAMED: ClassVar[Mapping[str, str]] = {
        "then": "mode_after",
        "call": "command",
        "least_confidence": "min_confidence",
        "fire_above": "",
        "halt_score_threshold": "",  # in motion moving.yaml: nearly_said
    }
    phrase: str = text()
    spellings: tuple[str, ...] = text()
    learned: tuple[str, ...] = text(default=())  # what the recogniser writes for one person's takes
    background: tuple[float, ...] = number(-1000.0, 1000.0, "nat", default=())  # of its score
    threshold: float = number(0.01, 1.0, "WER")
    modes: tuple[str, ...] = choice("standby", "active")
    mode_after: str = choice("same", "standby", "active")
    command: str = text(may_be_empty=True)  # what the robot knows: ros/robot/robot_commands.py
    is_motion: bool = flag()
    is_halt: bool = flag()
    min_confidence: float = number(0.0, 1.0, "")

    def __post_init__(self) -> None:
        """Write optional words out, and check what no key shows alone.

        Raises:
            CommandsError: Two keys contradict each other.
        """
        every = (
            text
            for i, spelling in enumerate(self.spellings)
            for text in without_brackets(f"spellings[{i}]", spelling)
        )
        object.__setattr__(self, "spellings", tuple(dict.fromkeys(every)))
        is_name = "[" not in self.phrase
        _require(is_name, "phrase", self.phrase, "the command's name, without [optional] words")
        _require(bool(self.modes), "modes", [], "standby, active or both")
        if self.command and self.command not in NOT_MOTIONS:
            words = f"true, as it calls {self.command!r}, which moves the robot"
            _require(self.is_motion, "is_motion", self.is_motion, words)
        if self.is_motion:
            _require(
                bool(self.command), "command", self.command, "what moves, as is_motion is true"
            )
            modes = list(self.modes)
            _require(self.modes == ("active",), "modes", modes, "[active], as it is a motion")
        if self.is_halt:
            self._check_halt()
        is_pair = len(self.background) == 2 and self.background[1] > 0.0
        allowed = "median and spread, the second above 0, or no such key"
        _require(is_pair or not self.background, "background", list(self.background), allowed)

    def _check_halt(self) -> None:
        _require(not self.is_motion, "is_motion", True, "false, as is_halt is true")
        _require(self.command in ("", "stop"), "command", self.command, '"" or stop, as it halts')
        both = {"standby", "active"}
        _require(set(self.modes) == both, "modes", list(self.modes), "[standby, active]: it halts")
        least, allowed = self.min_confidence, f"up to {NEVER_SURE}, or it is never heard"
        _require(least <= NEVER_SURE, "min_confidence", least, allowed)

    @property
    def all_spellings(self) -> Iterator[tuple[str, str]]:
        """Key and text of the phrase, of each spelling and of each one learned."""
        yield "phrase", self.phrase
        yield from ((f"spellings[{i}]", words) for i, words in enumerate(self.spellings))
        yield from ((f"learned[{i}]", words) for i, words in enumerate(self.learned))


@dataclass(frozen=True, kw_only=True)
class AmountCommand(CommandConfig):
    """A command with one amount of its slot, made of a phrase such as `pull {distance} more`."""

    template: str  # the phrase with its slot
    called: str  # `command` without the amount
    slot: SlotConfig
    value: float  # [slot.unit]

    @property
    def is_large(self) -> bool:
        """Whether it is asked for before it is done."""
        return self.value > self.slot.ask_above

    @property
    def too_large(self) -> str:
        """Why it is asked for, in words."""
        return f"{self.value:g} {self.slot.unit}, done at once: up to {self.slot.ask_above:g}"


@dataclass(frozen=True, kw_only=True)
class CommandsConfig:
    """All spoken commands; after `__post_init__` one for each amount of those with a slot."""

    language: str = choice(*LANGUAGES)
    answer_within: float = number(0.05, 30.0, "s")
    amounts: bool = flag()
    said_twice: bool = flag()  # each motion, before it is taken
    max_behind: float = number(0.0, 1000.0, "nat", default=0.0)  # 0: heard by its text
    slots: tuple[SlotConfig, ...] = items(0, 20)
    commands: tuple[CommandConfig, ...] = items(1, 200)

    def __post_init__(self) -> None:
        """Write amounts out, and check what no single key can show.

        Raises:
            CommandsError: A phrase is said twice, is too near to another, has no word, or a
                motion's phrase denies; nothing halts, or nothing wakes; a slot is not declared.
        """
        known: list[tuple[CommandConfig, str, Words]] = []
        phrases: set[str] = set()
        commands = list(self._written_out())
        object.__setattr__(self, "commands", tuple(command for _, command in commands))
        for where, command in commands:
            is_new = command.phrase not in phrases
            _require(is_new, f"{where}.phrase", command.phrase, "a name given once")
            phrases.add(command.phrase)
            allowed = "kana: kanji are spellings, since a phrase is compared by its sounds"
            _require(can_read(command.phrase), f"{where}.phrase", command.phrase, allowed)
            is_heard = self.language == ENGLISH or bool(command.background)
            allowed = f"what `{MEASURE_BACKGROUND}` prints for {command.phrase!r}"
            _require(is_heard, f"{where}.background", list(command.background), allowed)
            for key, spelling in command.all_spellings:
                is_plain = self.language != ENGLISH or spelling.isascii()
                _require(is_plain, f"{where}.{key}", spelling, "English, in letters a to z")
                words = _words(f"{where}.{key}", spelling, command.is_motion)
                for other, theirs, their_words in known:
                    if other is not command:
                        _require_apart(f"{where}.{key}", command, words, other, theirs, their_words)
                known.append((command, spelling, words))
        names = list(self.phrases)
        is_english = self.language == ENGLISH
        allowed = f"false with language {self.language}: amounts are English words"
        _require(is_english or not self.amounts, "amounts", True, allowed)
        allowed = "above 0 [nat]: what a motion's phrase may be less likely than the free text"
        _require(is_english or self.max_behind > 0.0, "max_behind", "missing, or 0", allowed)
        halts = any(c.is_halt for c in self.commands)
        _require(halts, "commands", names, "at least one with is_halt, such as stop")
        wakes = any("standby" in c.modes and c.mode_after == "active" for c in self.commands)
        allowed = "at least one that counts in standby and leads to active, such as hey robot"
        _require(wakes, "commands", names, allowed)

    def _written_out(self) -> Iterator[tuple[str, CommandConfig]]:
        """Each command with the key that it stands under; those with a slot once per amount."""
        for index, command in enumerate(self.commands):
            where = f"commands[{index}]"
            slot = slot_of(f"{where}.phrase", command.phrase, self.slots)
            for key, spelling in command.all_spellings:
                allowed = f"text with {{{slot.name}}}" if slot else "text without a slot"
                its_own = slot_of(f"{where}.{key}", spelling, self.slots) == slot
                _require(its_own, f"{where}.{key}", spelling, f"{allowed}, as its phrase")
            if slot is None:
                yield where, command
                continue
            _require(command.is_motion, f"{where}.is_motion", False, "true, as it takes an amount")
            if self.amounts:
                made = (_with_amount(command, slot, value) for value in slot.values)
                yield from ((where, one) for one in made)

    @property
    def phrases(self) -> tuple[str, ...]:
        """Names of all commands, in their order."""
        return tuple(command.phrase for command in self.commands)

    @property
    def fixed_phrases(self) -> tuple[str, ...]:
        """Names of those without an amount."""
        return tuple(c.phrase for c in self.commands if not isinstance(c, AmountCommand))

    def scored(self, taken: str, words: Words) -> dict[str, str]:
        """Per command the text by which the recogniser scores it: its phrase.

        Args:
            taken: The command that was taken; one whose phrase the recogniser cannot write is
                scored by what it learned to write for it, as it was written now. One with an amount
                is scored as it was written, beside the same text with every other number.
            words: Of the transcript, as it was written.
        """
        texts = {phrase: phrase for phrase in self.fixed_phrases}
        command = self.get(taken)
        if isinstance(command, AmountCommand):
            others = (c for c in self.commands if isinstance(c, AmountCommand))
            for other in others:
                if other.template == command.template:
                    texts[other.phrase] = " ".join(with_value(words, other.value))
                elif other.slot == command.slot and other.value == command.value:
                    texts[other.phrase] = other.phrase
            texts[taken] = " ".join(words)
        elif words in [normalize(text) for text in command.learned]:
            texts[taken] = " ".join(words)
        return texts

    def get(self, phrase: str) -> CommandConfig:
        """The command of that phrase.

        Raises:
            KeyError: There is none.
        """
        for command in self.commands:
            if command.phrase == phrase:
                return command
        raise KeyError(f"{phrase!r}, allowed: {', '.join(self.phrases)}")


def _require(is_allowed: bool, key: str, value: object, allowed: str) -> None:
    if not is_allowed:
        raise CommandsError(key, value, allowed)


def _with_amount(command: CommandConfig, slot: SlotConfig, value: float) -> AmountCommand:
    """A command that has a slot with one of its amounts in place of it."""
    hole, amounts = f"{{{slot.name}}}", slot.said(value)
    texts = (command.phrase, *command.spellings)
    said = [text.replace(hole, amount) for text in texts for amount in amounts]
    given = {field.name: getattr(command, field.name) for field in fields(command)}
    given |= {"phrase": said[0], "spellings": tuple(said[1:])}
    given["command"] = f"{command.command} {value:g} {slot.unit}"
    return AmountCommand(
        **given, template=command.phrase, called=command.command, slot=slot, value=value
    )


def _words(key: str, spelling: str, is_motion: bool) -> Words:
    words = normalize(spelling)
    _require(bool(words), key, spelling, "text with a word; it has no word")
    allowed = "no word that denies: a motion's phrase or spelling never denies"
    _require(not (is_motion and is_negated(words)), key, spelling, allowed)
    return words


def _require_apart(
    key: str,
    own: CommandConfig,
    words: Words,
    other: CommandConfig,
    theirs: str,
    others: Words,
) -> None:
    """Refuse two commands of which one, said without an error, would be taken for the other."""
    if amount_words(words) != amount_words(others) and not (own.is_halt or other.is_halt):
        return  # a number or a unit is never forgiven: intent/mapper.py
    spelling = " ".join(words)
    allowed = f"the words of one command; {theirs!r} belongs to {other.phrase!r}"
    _require(words != others, key, spelling, allowed)
    for command, error in ((other, wer(others, words)), (own, wer(words, others))):
        nearest = f"further from {theirs!r}, {other.phrase!r}: its WER {error:.2f} is below"
        allowed = f"{nearest} the threshold of {command.phrase!r}, {command.threshold:g}"
        _require(error >= command.threshold, key, spelling, allowed)

# SPDX-License-Identifier: BSD-3-Clause
"""Transcript to command by Word Error Rate; what is not clearly a command is none.

The rate is that of words. So "cameracloser" would be one wrong word and one that is missing, though
every letter of the command is there. A word that is a whole spelling written as one is parted
before the words are counted. Words that are apart are never joined: "re lease" is no "release".

A number or a unit is never forgiven: a command is taken only with the very numbers and units of a
spelling of it, so that "ten" is no "two" however long the phrase is.

A rate says little of how near a command is where none was said: the longer of two spellings has the
lower one. So the nearest command is that which some of the words sound most like.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache
from itertools import chain

from voice_assist.config import CommandsConfig
from voice_assist.config.commands import AmountCommand
from voice_assist.intent.amounts import AmountTalk
from voice_assist.text.amounts import amount_words, canonical
from voice_assist.text.normalize import (
    LONGEST,
    Words,
    as_text,
    contains,
    foreign,
    is_negated,
    is_too_long,
    normalize,
)
from voice_assist.text.phonetic_distance import distance, sounds_of_letters
from voice_assist.text.wer import min_distance, wer
from voice_assist.types import Match, NoMatch, Rejection, RejectionReason

SILENCE = "nothing was said"
_COMPARED = 50  # words that the nearest command is sought in; an utterance has fewer


class Mapper:
    """Names the command whose words are nearest to the transcript's, if they are near enough."""

    def __init__(self, config: CommandsConfig) -> None:
        """Prepare the words of every command and its spellings."""
        self._spellings: dict[str, tuple[Words, ...]] = {
            command.phrase: tuple(normalize(spelling) for _, spelling in command.all_spellings)
            for command in config.commands
        }
        self._phrases = {phrase: normalize(phrase) for phrase in self._spellings}
        written = " ".join(text for c in config.commands for _, text in c.all_spellings)
        self._letters = frozenset(c for c in written.lower() if not c.isascii())
        self._joined = _joined(chain.from_iterable(self._spellings.values()))
        self._thresholds = {command.phrase: command.threshold for command in config.commands}
        self._halts = {command.phrase for command in config.commands if command.is_halt}
        amounts = [c for c in config.commands if isinstance(c, AmountCommand)]
        self._amount_talk = AmountTalk(amounts) if amounts else None

    def __call__(self, transcript: str) -> Match | NoMatch:
        """The command with the lowest WER below its own threshold.

        Only a halt is taken from a text with letters that neither English nor a command has, and
        nothing from a text longer than LONGEST, whose errors are those of its beginning.

        Args:
            transcript: As recognised; may have punctuation, contractions and capitals.
        """
        words = self.words(transcript)
        errors = self._errors(words)
        if is_too_long(transcript):
            return _no_command(f"{len(transcript)} characters, allowed: {LONGEST}", "", errors)
        if not words:
            return _no_command(SILENCE, "", errors)
        if (halt := self._halt_among_amounts(words)) is not None:
            return Match(halt, errors)
        near = self._near(words, errors)
        best = [phrase for phrase, error in near.items() if error == min(near.values())]
        if len(best) == 1 and (near[best[0]] == 0.0 or not is_negated(words)):
            odd = foreign(transcript, self._letters)
            if odd and best[0] not in self._halts:
                why = f"U+{ord(odd):04X} in it, which no command has"
                return _no_command(why, best[0], errors)
            return Match(best[0], errors)
        nearest = self._nearest(words, errors)
        return _no_command(self._reason(words, nearest, errors, best), nearest, errors)

    def almost(self, transcript: str, limit: float) -> Match | None:
        """The command that all words of a transcript together sound most like.

        Args:
            transcript: That was taken for no command.
            limit: Distance of their sounds from the phrase's, in [0, 1], up to which it counts.

        Returns:
            None where none is so near, and for what denies, has a number or strange letters, has a
            halt in it, or more words beside the phrase itself.
        """
        words = self.words(transcript)
        is_other = not words or is_negated(words) or amount_words(words)
        if is_other or is_too_long(transcript) or foreign(transcript, self._letters):
            return None
        fixed = {p: own for p, own in self._phrases.items() if not amount_words(own)}
        apart = {phrase: _apart(own, words) for phrase, own in fixed.items()}
        nearest = min(apart, key=apart.__getitem__)
        halts = (spelling for phrase in self._halts for spelling in self._spellings[phrase])
        is_more = any(contains(words, said) for said in (fixed[nearest], *halts))
        is_almost = apart[nearest] <= limit and not is_more
        return Match(nearest, self._errors(words)) if is_almost else None

    def words(self, transcript: str) -> Words:
        """Words of a transcript; an amount is in the words by which it is known."""
        words = self.written(transcript)
        return words if self._amount_talk is None else canonical(words)

    def written(self, transcript: str) -> Words:
        """Words of a transcript as they were written; those that run together are parted."""
        return tuple(
            part for word in normalize(transcript) for part in self._joined.get(word, (word,))
        )

    def can_grow(self, transcript: str) -> bool:
        """Whether more words could make another command of it, other than a halt.

        A halt may follow any decision, so nothing has to wait for one.
        """
        words = self.words(transcript)
        outcome = self(transcript)
        own = outcome.command if isinstance(outcome, Match) else ""
        return any(
            len(spelling) > len(words) and spelling[: len(words)] == words
            for phrase, spellings in self._spellings.items()
            if phrase != own and phrase not in self._halts
            for spelling in spellings
        )

    def cannot_become(self, beginning: str) -> bool:
        """Whether no text that begins so can be taken for a command, whatever follows.

        What follows the last space may be part of a word, and counts for nothing. Of the rest, the
        distance to the best beginning of a spelling stays in every longer text.

        Args:
            beginning: Of a transcript, without contractions that go on after a space.
        """
        words = self.words(beginning.rpartition(" ")[0])
        if self._amount_talk is not None:
            words = self._amount_talk.settled(words)
        return bool(words) and all(
            min_distance(spelling, words) / len(spelling) >= self._thresholds[phrase]
            for phrase, spellings in self._spellings.items()
            for spelling in spellings
        )

    def accepted(self) -> dict[str, tuple[str, ...]]:
        """Per command every phrase that is taken for it without an error, in normalised words."""
        return {
            phrase: tuple(dict.fromkeys(as_text(words) for words in spellings))
            for phrase, spellings in self._spellings.items()
        }

    def _near(self, words: Words, errors: dict[str, float]) -> dict[str, float]:
        """WER of the commands that are near enough, with the very numbers and units heard."""
        said, near = amount_words(words), {}
        for phrase, error in errors.items():
            if error >= self._thresholds[phrase]:
                continue
            if phrase not in self._halts:
                same = (s for s in self._spellings[phrase] if amount_words(s) == said)
                error = min((wer(spelling, words) for spelling in same), default=1.0)
            if error < self._thresholds[phrase]:
                near[phrase] = error
        return near

    def _halt_among_amounts(self, words: Words) -> str | None:
        """A halt at the end of what began as a command with an amount; None: there is none."""
        if self._amount_talk is None:
            return None
        for phrase in self._halts:
            for halt in self._spellings[phrase]:
                begun = words[: -len(halt)]
                if begun and words[-len(halt) :] == halt and self._amount_talk.is_made_of(begun):
                    return phrase
        return None

    def _errors(self, words: Words) -> dict[str, float]:
        return {
            phrase: min(wer(spelling, words) for spelling in spellings)
            for phrase, spellings in self._spellings.items()
        }

    def _nearest(self, words: Words, errors: dict[str, float]) -> str:
        """The command said without an error, else that which some of the words sound most like."""
        best = min(errors, key=errors.__getitem__)
        if errors[best] == 0.0:
            return best
        some, said = words[:_COMPARED], amount_words(words)
        alike = [p for p, own in self._phrases.items() if amount_words(own) in ((), said)]
        return min(alike, key=lambda phrase: _least_apart(self._phrases[phrase], some))

    def _reason(self, words: Words, nearest: str, errors: dict[str, float], best: list[str]) -> str:
        if is_negated(words):
            return "it denies; what is denied never moves"
        if len(best) > 1:
            return "it fits " + " and ".join(repr(phrase) for phrase in best) + " equally well"
        if self._amount_talk is not None and (why := self._amount_talk.refusal(words)):
            return why
        error, allowed = errors[nearest], self._thresholds[nearest]
        return f"WER {error:.2f} to {nearest!r}, allowed below {allowed:.2f}"


def _joined(spellings: Iterable[Words]) -> dict[str, Words]:
    """Spellings of several words, by the one word that they are where nothing parts them."""
    every = list(spellings)
    known = set(chain.from_iterable(every))
    joined = {"".join(words): words for words in every if len(words) > 1}
    return {word: words for word, words in joined.items() if word not in known}


def _least_apart(phrase: Words, words: Words) -> float:
    """How far the phrase is in sound from those of the words, side by side, that are nearest."""
    size = min(len(phrase), len(words))
    return min(_apart(phrase, words[at : at + size]) for at in range(len(words) - size + 1))


@lru_cache(4096)  # a transcript that grows has the same words again and again
def _apart(one: Words, other: Words) -> float:
    return distance(*(sounds_of_letters(" ".join(words)) for words in (one, other)))


def _no_command(words: str, nearest: str, errors: dict[str, float]) -> NoMatch:
    return NoMatch(Rejection(RejectionReason.NO_COMMAND, words), nearest, errors)

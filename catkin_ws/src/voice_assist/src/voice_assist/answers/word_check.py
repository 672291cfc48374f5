# SPDX-License-Identifier: BSD-3-Clause
"""Whether a sentence may be said beside the microphone: no command, and nothing like one."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

from voice_assist.config.commands import CommandsConfig
from voice_assist.text.normalize import is_japanese, normalize
from voice_assist.text.phonetic_distance import can_read, distance, espeak_language, sounds

YES: Final = "yes"  # the answer to a motion that is asked for
NEAREST: Final = 0.33  # distance in sound that is allowed, as `confusability` warns below it
_LEFT_ALONE: Final = 3  # letters that a command's word needs to be sought at the start of others


class WordCheck:
    """Compares sentences with all that can be said.

    Args:
        commands: All commands with their spellings.
    """

    def __init__(self, commands: CommandsConfig) -> None:
        spellings = [text for c in commands.commands for _, text in c.all_spellings]
        known = dict.fromkeys((*spellings, YES))
        words = {word for text in known for word in normalize(text)}
        self._language = espeak_language(commands.language)
        self._words = {w for w in words if len(w) > 1 or not is_japanese(w)}  # one kana is no word
        self._sounds = {text: self._said(text) for text in known if can_read(text)}

    def objection(self, sentence: str) -> str:
        """Why the sentence may not be said; empty: it may.

        Args:
            sentence: Of a few words.

        Returns:
            The command's word that it holds, or the spelling that a part of it sounds like.
        """
        for word in normalize(sentence):
            found = next((one for one in sorted(self._words) if _begins(word, one)), "")
            if found:
                return f"{word!r} is or begins with {found!r}, a word of a command"
        near, text = min((self._nearest(sentence, text), text) for text in self._sounds)
        if near < NEAREST:
            return f"{near:.2f} from {text!r} in sound, allowed: {NEAREST:.2f} and more"
        return ""

    def _said(self, text: str) -> tuple[str, ...]:
        return sounds(text, self._language)

    def _nearest(self, sentence: str, text: str) -> float:
        """Distance of the spelling to that part of the sentence which sounds most like it."""
        said, sought = self._said(sentence), self._sounds[text]
        lengths = range(max(len(sought) - 1, 1), len(sought) + 2)
        parts = (said[i : i + n] for n in lengths for i in range(max(len(said) - n, 0) + 1))
        return min((distance(part, sought) for part in _distinct(parts)), default=1.0)


def _begins(word: str, command_word: str) -> bool:
    is_long = len(command_word) >= _LEFT_ALONE
    return word.startswith(command_word) if is_long else word == command_word


def _distinct(parts: Iterable[tuple[str, ...]]) -> Iterable[tuple[str, ...]]:
    return dict.fromkeys(parts)

# SPDX-License-Identifier: BSD-3-Clause
"""What people are told, in the language of the commands: `texts/<language>.yaml`."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Final

from typed_config import load_yaml, package_folder, require
from voice_assist.config.commands import ENGLISH, LANGUAGES, CommandsConfig

TEXTS_DIR: Final = package_folder("voice_assist") / "texts"
_QUOTED: Final = re.compile(r'"([a-z ]+)"')  # how English sentences name a command
_NAMED: Final = re.compile(r"\{([a-z ]+)\}")  # how those of the catalogues do


class Texts:
    """Sentences of answers and alarms in one language; what has no entry stays English."""

    def __init__(self, language: str = ENGLISH, phrases: Mapping[str, str] | None = None) -> None:
        """Read the catalogue.

        Args:
            language: One of LANGUAGES.
            phrases: By what each command calls, how it is said; None: as it is called.

        Raises:
            ConfigError: There is no such language, or its file is not as it must be.
        """
        self._sentences = {} if language == ENGLISH else _sentences(language)
        self._phrases = phrases or {}

    def __call__(self, english: str) -> str:
        """A sentence in the language, with the phrases of the commands that it names.

        A command that no phrase calls is named as the robot knows it.
        """
        text = self._sentences.get(english) or _QUOTED.sub(r'"{\1}"', english)
        return _NAMED.sub(lambda named: self._phrases.get(named[1], named[1]), text)


def texts_of(commands: CommandsConfig) -> Texts:
    """The texts in the language of the commands, which names them as they are said."""
    phrases: dict[str, str] = {}
    for command in commands.commands:
        phrases.setdefault(command.command, command.phrase)
    return Texts(commands.language, phrases)


def page_texts(language: str) -> dict[str, str]:
    """Texts of the operator's page by the English ones.

    Raises:
        ConfigError: There is no such language, or its file is not as it must be.
    """
    return {} if language == ENGLISH else dict(_read(language)["page"])


def _sentences(language: str) -> dict[str, str]:
    sections = _read(language)
    return {**sections["answers"], **sections["alarms"]}


def _read(language: str) -> Mapping[str, Mapping[str, str]]:
    require(language in LANGUAGES, "language", language, ", ".join(LANGUAGES))
    found: Mapping[str, Mapping[str, str]] = load_yaml(TEXTS_DIR / f"{language}.yaml")
    return found

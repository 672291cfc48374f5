# SPDX-License-Identifier: BSD-3-Clause
"""Commands, takes and lists of recordings as files hold them, for a test to change."""

from dataclasses import replace

from voice_assist.config import load_voice_config
from voice_assist.profile.manifest import COMMAND, Take

SPEECH_HEAD = (
    "path,kind,transcript,speaker,seconds,licence,source,split\n"  # of recordings to train on
)


def command_entries():
    """The shipped commands, each as an entry of commands.yaml."""
    shipped = load_voice_config().commands.commands
    return [{**vars(command), "spellings": list(command.spellings)} for command in shipped]


def altered(commands, **changes):
    """Commands of which some, by their phrases with `_` for a space, are others in some things."""
    every = (replace(c, **changes.get(c.phrase.replace(" ", "_"), {})) for c in commands.commands)
    return replace(commands, commands=tuple(every))


def take(phrase="tense"):
    """A good take of a command."""
    return Take(
        file="takes/0000.wav",
        sha256="0" * 64,
        kind=COMMAND,
        phrase=phrase,
        time="2026-11-21T20:00:00+00:00",
        source="microphone",
        seconds=1.0,
        level_db=-20.0,
        snr_db=30.0,
        heard=phrase,
        verdict="good",
    )

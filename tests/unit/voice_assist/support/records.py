# SPDX-License-Identifier: BSD-3-Clause
"""Commands and takes as files hold them, for a test to change."""

from voice_assist.config import load_voice_config
from voice_assist.profile.manifest import COMMAND, Take


def command_entries():
    """The shipped commands, each as an entry of commands.yaml."""
    shipped = load_voice_config().commands.commands
    return [{**vars(command), "spellings": list(command.spellings)} for command in shipped]


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

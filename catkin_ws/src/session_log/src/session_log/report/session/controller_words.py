# SPDX-License-Identifier: BSD-3-Clause
"""What the controller calls a phrase: two may stop it, and any may be named otherwise."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from session_log.mcap_file.condition import FileCondition
from session_log.recording.metadata import PARAMETERS, settings_at

STOP = "stop"


def controller_words(condition: FileCondition, publishers: Iterable[str]) -> dict[str, str]:
    """By phrase the command that is sent for it; the phrase itself where none is sent.

    Phrases with an amount, and those of recordings without these settings, are not among them.

    Args:
        condition: Of the recording, with its metadata.
        publishers: Nodes that heard the phrases; each has its commands among its own parameters.
    """
    found: dict[str, str] = {}
    for publisher in publishers:
        for command in _commands(condition, publisher):
            sent = STOP if command.get("is_halt") is True else command["command"]
            found[command["phrase"]] = sent or command["phrase"]
    return found


def _commands(condition: FileCondition, publisher: str) -> Iterator[Mapping[str, Any]]:
    """The commands of a node over the whole recording, later ones last."""
    key = publisher.strip("/").partition("/")[0]
    texts = [values.get(key, "") for name, values in condition.metadata if name == PARAMETERS]
    for text in dict.fromkeys(texts):  # written again where any parameter changes
        listed = settings_at({key: text}, f"{publisher}/commands").get("commands")
        for command in listed if isinstance(listed, list) else ():
            if isinstance(command, Mapping) and _is_named(command):
                yield command


def _is_named(command: Mapping[str, Any]) -> bool:
    """Whether it has both names; the older of our recordings call one of them otherwise."""
    return all(isinstance(command.get(key), str) for key in ("phrase", "command"))

# SPDX-License-Identifier: BSD-3-Clause
"""Errors of the voice package; each names the value and what was allowed."""

from __future__ import annotations

from collections.abc import Sequence

from typed_config import ConfigError


class VoiceError(Exception):
    """Base of every error that this package raises."""


class AudioError(VoiceError):
    """Sound could not be read, or is not what it must be."""


class DeviceError(AudioError):
    """A microphone is missing or was lost."""

    def __init__(self, problem: str, device: str = "", found: Sequence[str] = ()) -> None:
        """Keep the facts.

        Args:
            problem: What happened, in words.
            device: The microphone that was asked for; empty for the system's default.
            found: Names of the microphones that exist now.
        """
        exist = ", ".join(repr(name) for name in found) or "none"
        asked = f"microphone {device!r}" if device else "default microphone"
        super().__init__(f"{asked}: {problem}; microphones found: {exist}")
        self.device, self.found = device, tuple(found)


class ModelError(VoiceError):
    """A recogniser's checkpoint is missing or damaged."""


class CommandsError(VoiceError, ConfigError):
    """The commands in commands.yaml contradict each other; names key, value, what was allowed."""


class ManifestError(VoiceError):
    """A list of recordings, a row of it, or a recording cannot be used."""

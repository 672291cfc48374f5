# SPDX-License-Identifier: BSD-3-Clause
"""What a replay needs of the pipeline that hears recorded sound again, and how it is found.

This package does not know the voice part: a setting names `module:function`, which is imported when
it is needed. The function is a `MakePipeline`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from session_log.errors import SessionLogError


class PluginMissing(SessionLogError):
    """There is no pipeline to hear the sound again."""

    def __init__(self, name: str, why: str) -> None:
        super().__init__(f"pipeline {name!r} of replay.yaml: {why}; allowed: module:function")


@dataclass(frozen=True, eq=False)
class RecordedSound:
    """One recorded block of sound."""

    samples: NDArray[np.int16]  # (n,), mono
    rate: int  # [Hz]
    first_sample: int  # index of samples[0] since the stream began
    stamp: float  # [s] clock time at which samples[0] was captured


class Decided(Protocol):
    """One decision, with the fields of the message voice_assist/Utterance; times in [s]."""

    @property
    def transcript(self) -> str: ...  # noqa: D102 - the message explains its fields
    @property
    def wer(self) -> Mapping[str, float]: ...  # noqa: D102
    @property
    def command(self) -> str: ...  # noqa: D102
    @property
    def reason(self) -> str: ...  # noqa: D102
    @property
    def nearest_command(self) -> str: ...  # noqa: D102
    @property
    def confidence(self) -> float: ...  # noqa: D102
    @property
    def mode(self) -> str: ...  # noqa: D102
    @property
    def decided_by(self) -> str: ...  # noqa: D102
    @property
    def is_partial(self) -> bool: ...  # noqa: D102
    @property
    def speech_start(self) -> float: ...  # noqa: D102
    @property
    def speech_end(self) -> float: ...  # noqa: D102
    @property
    def decision(self) -> float: ...  # noqa: D102


class ReplayPipeline(Protocol):
    """The live pipeline in lock-step: its clock shows the recorded stamps, never the time."""

    model: str  # as asked for
    model_hash: str  # SHA-256, hexadecimal
    spotter_hash: str  # empty: no spotter
    warnings: tuple[str, ...]  # what of the recorded settings could not be restored

    def hear(self, sound: RecordedSound) -> Sequence[Decided]:
        """Take the next block of sound; gives what was decided with it, oldest first.

        Raises:
            ValueError: The block does not suit the pipeline.
        """

    def set_mode(self, mode: str, reason: str) -> None:
        """Take over a recorded mode, where what led to it is lost."""

    def heard_live(self, first_sample: int) -> bool:
        """Whether it is on record that the live pipeline decided on the block of a sample."""

    def lost_live(self, first_sample: int) -> bool:
        """Whether the live pipeline, too, lacked the sound in front of a sample."""


class MakePipeline(Protocol):
    """Builds the pipeline of one run of the voice node."""

    def __call__(
        self, settings: Mapping[str, Any], notes: Sequence[str], model: str | None
    ) -> ReplayPipeline:
        """Start a pipeline as the node started.

        Args:
            settings: The voice part's recorded parameters; empty: none were recorded.
            notes: What hearing depended on other than the sound, as recorded.
            model: Recogniser in place of the recorded one; None: that one.

        Raises:
            ValueError: Something of it cannot be used.
        """


def find_plugin(name: str) -> MakePipeline:
    """Import `module:function`.

    Raises:
        PluginMissing: The package is not there, or has no such function.
    """
    module, _, function = name.partition(":")
    try:
        made = getattr(import_module(module), function, None)
    except ImportError as error:
        raise PluginMissing(name, f"cannot be imported ({error})") from error
    if not callable(made):
        raise PluginMissing(name, f"{module} has no function {function!r}")
    found: MakePipeline = made
    return found

# SPDX-License-Identifier: BSD-3-Clause
"""Settings of `session_log replay`; config/replay.yaml explains each key."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from session_log.config import require_topics
from typed_config import number, require, text


@dataclass(frozen=True, kw_only=True)
class ReplayTopics:
    """Where a recording holds what was heard."""

    audio: str = text()
    utterance: str = text()
    mode: str = text()
    circumstances: str = text()

    def __post_init__(self) -> None:
        """Check what no key's range can show."""
        require_topics(self)


@dataclass(frozen=True, kw_only=True)
class ReplayConfig:
    """Which pipeline hears again, and what counts as the same."""

    RENAMED: ClassVar[Mapping[str, str]] = {"hearer": "pipeline"}

    pipeline: str = text()
    topics: ReplayTopics
    settings: str = text()
    facts: str = text()
    confidence_tolerance: float = number(0.0, 0.05, "")
    wer_tolerance: float = number(0.0, 1e-5, "WER")
    time_tolerance: float = number(0.0, 1.0, "s")
    match_window: float = number(0.0, 60.0, "s")
    settling: float = number(0.0, 60.0, "s")
    tail: float = number(0.0, 60.0, "s")

    def __post_init__(self) -> None:
        """Check what no key's range can show."""
        module, _, function = self.pipeline.partition(":")
        is_path = all(word.isidentifier() for word in (*module.split("."), function))
        words = "module:function; this is no module and function"
        require(is_path, "pipeline", self.pipeline, words)

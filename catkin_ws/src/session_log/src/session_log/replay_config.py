# SPDX-License-Identifier: BSD-3-Clause
"""Settings of `session_log replay`; config/replay.yaml explains each key."""

from __future__ import annotations

from dataclasses import dataclass

from typed_config import number, text


@dataclass(frozen=True, kw_only=True)
class ReplayTopics:
    """Where a recording holds what was heard."""

    audio: str = text()
    utterance: str = text()
    mode: str = text()
    circumstances: str = text()


@dataclass(frozen=True, kw_only=True)
class ReplayConfig:
    """Who hears again, and what counts as the same."""

    hearer: str = text()
    topics: ReplayTopics
    settings: str = text()
    facts: str = text()
    confidence_tolerance: float = number(0.0, 1.0, "")
    wer_tolerance: float = number(0.0, 1.0, "WER")
    time_tolerance: float = number(0.0, 10.0, "s")
    match_window: float = number(0.0, 60.0, "s")
    settling: float = number(0.0, 60.0, "s")
    tail: float = number(0.0, 60.0, "s")

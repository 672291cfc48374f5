# SPDX-License-Identifier: BSD-3-Clause
"""Settings of the recorder and of the report; the YAML files under config/ explain each key."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from typed_config import ConfigError, flag, integer, items, number, require, text

TOPIC = re.compile(r"(/[A-Za-z]\w*)+", re.ASCII)
FOLDER = "a whole path, or one that begins with ~: a node runs in a folder of its own"
LEAST_SPACE = 10_000_000  # [B] below it no recording goes on


@dataclass(frozen=True, kw_only=True)
class RecorderConfig:
    """What to record, where to, and how much may wait in memory."""

    folder: str = text(may_be_empty=True)
    name: str = text(may_be_empty=True)
    exclude: tuple[str, ...] = text()
    subscribe_early: tuple[str, ...] = text()
    wait_for: tuple[str, ...] = text()
    wait_timeout: float = number(0.0, 3600.0, "s")
    discovery_period: float = number(0.05, 10.0, "s")
    flush_period: float = number(0.0005, 1.0, "s")
    sync_period: float = number(0.0, 600.0, "s")
    retry_period: float = number(0.05, 60.0, "s")
    stall_time: float = number(0.1, 600.0, "s")
    queue_messages: int = integer(100, 10_000_000, "messages")
    queue_size: int = integer(1_000_000, 8_000_000_000, "B")
    low_space: int = integer(0, 1_000_000_000_000, "B")
    acknowledge_rate: float = number(0.1, 100.0, "Hz")
    parameters_period: float = number(0.5, 3600.0, "s")
    seed: int = integer(0, 2**31 - 1)

    def __post_init__(self) -> None:
        """Check what no key's range can show."""
        require(not self.folder or _is_whole(self.folder), "folder", self.folder, FOLDER)
        _require_patterns(self.exclude)
        for key in ("subscribe_early", "wait_for"):
            for index, topic in enumerate(getattr(self, key)):
                is_topic = TOPIC.fullmatch(topic) is not None
                require(is_topic, f"{key}[{index}]", topic, "the whole name of a topic: /name")
        is_space = self.low_space == 0 or self.low_space >= LEAST_SPACE
        allowed = f"0, which warns never, or from {LEAST_SPACE} B on"
        require(is_space, "low_space", self.low_space, allowed)
        least = 2.0 * self.flush_period  # the disk takes something once in each period
        allowed = f"at least twice flush_period, {least:g} s"
        require(self.stall_time >= least, "stall_time", self.stall_time, allowed)


@dataclass(frozen=True, kw_only=True)
class FoxgloveConfig:
    """Where topics are served live, and which."""

    address: str = text()
    port: int = integer(0, 65535)
    exclude: tuple[str, ...] = text()
    discovery_period: float = number(0.1, 60.0, "s")
    backlog: int = integer(16, 100_000, "messages")

    def __post_init__(self) -> None:
        """Check what no key's range can show."""
        _require_patterns(self.exclude)


@dataclass(frozen=True, kw_only=True)
class ReportTopics:
    """Where the report looks for what."""

    utterance: str = text()
    mode: str = text()
    audio: str = text()
    event: str = text()
    device: str = text()
    state: str = text()
    tension: str = text()
    joint_states: str = text()
    set_points: str = text()
    picture: str = text()
    diagnostics: str = text()
    trocar: str = text()
    intended: str = text()

    def __post_init__(self) -> None:
        """Check what no key's range can show."""
        require_topics(self)


@dataclass(frozen=True, kw_only=True)
class ShaftLinks:
    """Where the shaft is in the recorded robot model."""

    base: str = text()
    link: str = text()
    tip: str = text()


@dataclass(frozen=True, kw_only=True)
class PaperLatencyConfig:
    """One row of the paper's table 1."""

    command: str = text()
    latency: float = number(0.0, 60.0, "s")


@dataclass(frozen=True, kw_only=True)
class PaperConfig:
    """What the paper reports, and where it stands."""

    source: str = text()
    hardware: str = text()
    repetitions: int = integer(0, 100_000)
    latency: tuple[PaperLatencyConfig, ...] = items(0, 100)


@dataclass(frozen=True, kw_only=True)
class ReportConfig:
    """What the report reads and the lines it draws."""

    topics: ReportTopics
    rcm_limit: float = number(1e-9, 0.01, "m")
    shaft: ShaftLinks
    match_window: float = number(0.0, 60.0, "s")
    intended_window: float = number(0.0, 600.0, "s")
    intended_slack: float = number(0.0, 5.0, "s")
    motion_window: float = number(0.0, 600.0, "s")
    sample_period: float = number(0.001, 10.0, "s")
    late_factor: float = number(1.0, 100.0, "")
    pictures: int = integer(0, 64)
    utterance_sound: bool = flag()
    paper: PaperConfig
    resolution: int = integer(50, 600, "dpi")
    vector: bool = flag()


def require_topics(topics: object) -> None:
    """Refuse what is no topic among the values of a settings dataclass of topics.

    Raises:
        ConfigError: It is none.
    """
    for key, topic in vars(topics).items():
        require(TOPIC.fullmatch(topic) is not None, key, topic, "the whole name of a topic: /name")


def _is_whole(folder: str) -> bool:
    try:
        return Path(folder).expanduser().is_absolute()
    except RuntimeError:  # of a person who is not known here
        return False


def _require_patterns(patterns: tuple[str, ...]) -> None:
    for index, pattern in enumerate(patterns):
        try:
            re.compile(pattern)
        except re.error as error:
            allowed = f"a regular expression; this one is none: {error}"
            raise ConfigError(f"exclude[{index}]", pattern, allowed) from error

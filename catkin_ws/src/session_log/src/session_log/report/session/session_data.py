# SPDX-License-Identifier: BSD-3-Clause
"""What the report needs of a session, in plain values; all times in [s] since its first message."""

from __future__ import annotations

import math
from array import array
from collections import Counter
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from session_log.mcap_file.summary import RecordingSummary

Track = NDArray[np.float64]
MOVING = ("moving", "stopping")  # states of the controller in which the robot moves
SILENT = 0.5  # [s] without a message of a fast topic: nobody knows what held meanwhile
ERROR, STALE = 2, 3  # levels of diagnostics
DEVICES = "devices"  # what answers a call to a device, which is no node of the controller


@dataclass(frozen=True)
class RecordedUtterance:
    """One decision of the recogniser."""

    speech_start: float  # [s]
    speech_end: float  # [s]
    decision: float  # [s]
    transcript: str
    command: str  # empty: none was chosen
    reason: str  # why none was chosen
    nearest_command: str
    wer: float  # of the nearest command; nan if none was compared
    is_partial: bool
    publisher: str = ""  # node that said so; older recordings have none


@dataclass(frozen=True)
class IntendedPhrase:
    """A phrase that began to sound, as its player or prompter reported it."""

    time: float  # [s]
    phrase: str  # the exact command; empty: words that are no command


@dataclass(frozen=True)
class RecordedTrocar:
    """The remote centre of motion, from a moment on."""

    time: float  # [s]
    position: tuple[float, float, float]  # [m], in `frame`
    frame: str


@dataclass(frozen=True)
class RecordedEvent:
    """One event of the controller, or what came of a call to a device."""

    time: float  # [s]
    kind: str
    command: str
    message: str
    reason_code: str = ""  # older recordings have none
    caller: str = ""  # node that asked; older recordings have none


@dataclass(frozen=True)
class Span:
    """A stretch of time during which a word held."""

    start: float  # [s]
    end: float  # [s]
    word: str


@dataclass(frozen=True)
class RecordedPicture:
    """One picture of the scene."""

    time: float  # [s]
    format: str  # png or jpeg
    data: bytes


@dataclass(frozen=True)
class NodeHealth:
    """What one diagnostic status said over the session."""

    name: str
    worst: int  # 0 OK, 1 WARN, ERROR, STALE
    worst_message: str
    worst_time: float  # [s]
    last_message: str
    values: dict[str, str]

    @property
    def severity(self) -> float:
        """Rank of the worst: nothing is above an error."""
        return math.inf if self.worst == ERROR else self.worst


@dataclass(eq=False)
class SampledTable:
    """Numbers sampled over time."""

    columns: tuple[str, ...]
    _rows: array[float] = field(default_factory=lambda: array("d"))

    def extend(self, *columns: NDArray[Any]) -> None:
        """Add rows by their columns, each of shape (n,), the time [s] first."""
        self._rows.frombytes(np.column_stack(columns).astype(float).tobytes())

    def sort(self) -> None:
        """Put the rows in order of time; those of the same time keep theirs.

        Each publisher of a topic adds its rows in blocks, which overlap in time.
        """
        grid = np.asarray(self._rows).reshape(-1, len(self.columns))  # (n, columns)
        if (np.diff(grid[:, 0]) < 0.0).any():
            order = np.argsort(grid[:, 0], kind="stable")
            self._rows = array("d", grid[order].tobytes())

    def __len__(self) -> int:
        return len(self._rows) // len(self.columns)

    def __getitem__(self, column: str) -> Track:
        grid = np.array(self._rows).reshape(-1, len(self.columns))  # (n, columns)
        return grid[:, self.columns.index(column)]


@dataclass(eq=False)
class Intervals:
    """Time between consecutive messages of a fast topic, from their stamps."""

    topic: str
    length: array[float] = field(default_factory=lambda: array("f"))  # [s]

    def extend(self, length: Track) -> None:
        """Add intervals [s], shape (n,)."""
        self.length.frombytes(length.astype(np.float32).tobytes())


@dataclass
class SessionData:
    """Everything the report draws from."""

    recording: RecordingSummary
    heard: list[RecordedUtterance] = field(default_factory=list)
    events: list[RecordedEvent] = field(default_factory=list)
    device_calls: list[RecordedEvent] = field(default_factory=list)  # accepted or refused
    modes: list[Span] = field(default_factory=list)
    states: list[Span] = field(default_factory=list)
    phases: list[Span] = field(default_factory=list)
    controller: SampledTable = field(  # rcm_error is nan while the tool is outside the patient
        default_factory=lambda: SampledTable(("time", "rcm_error", "tension", "target", "moving"))
    )
    tension: SampledTable = field(  # the largest of each sample period
        default_factory=lambda: SampledTable(("time", "tension"))
    )
    joints: SampledTable | None = None  # columns: time and the names of the joints, [rad]
    joint_ranges: dict[str, tuple[float, float]] = field(  # least and largest of all joint states
        default_factory=dict
    )
    rcm_peaks: SampledTable = field(  # the largest of each sample period, from all joint states
        default_factory=lambda: SampledTable(("time", "error"))
    )
    other_joints: int = 0  # samples that name others, or do not fit their names
    sound: SampledTable = field(default_factory=lambda: SampledTable(("time", "level")))  # [dBFS]
    loops: list[Intervals] = field(default_factory=list)
    health: list[NodeHealth] = field(default_factory=list)
    pictures: list[RecordedPicture] = field(default_factory=list)
    urdf: str = ""
    undecodable: Counter[str] = field(default_factory=Counter)  # messages by topic
    clock_lags: dict[str, float] = field(  # of topics that another clock stamped, or did at times:
        default_factory=dict  # from stamp to arrival, where it is most [s]
    )
    clock_offsets: dict[str, float] = field(  # of topics whose clock is a little off: likewise,
        default_factory=dict  # at the least; their times are left as they are
    )
    missing_fields: set[str] = field(default_factory=set)  # what was recorded without which field
    intended: list[IntendedPhrase] = field(default_factory=list)
    phrases: tuple[str, ...] = ()  # every command that the recogniser ever compared with
    called: dict[str, str] = field(  # by phrase: what the controller calls it, by recorded settings
        default_factory=dict
    )
    trocars: list[RecordedTrocar] = field(default_factory=list)
    sounds: dict[RecordedUtterance, bytes] = field(default_factory=dict)  # MP3, where asked for

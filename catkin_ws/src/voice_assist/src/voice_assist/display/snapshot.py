# SPDX-License-Identifier: BSD-3-Clause
"""What a viewer sees at one moment; each part with the age of its newest news."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class RobotPart:
    """What the controller does."""

    state: str  # standby, active, moving, stopping, halted or faulted
    phase: str
    command: str  # in execution, or the last one
    progress: float  # [0, 1] of the phase
    is_tissue_held: bool
    halt_reason: str
    remaining: float | None = None  # [s] of the phase, estimated; None: unknown
    words: tuple[str, ...] = ()  # spoken words that count now
    age: float = 0.0  # [s]


@dataclass(frozen=True)
class TissuePart:
    """Tissue and trocar; None: not known, or no number."""

    tension: float | None  # [N]
    tension_target: float | None  # [N]; None: none is set
    rcm_error: float | None  # [m]
    insertion: float | None  # [m] of the tip in the trocar; negative: outside
    invalid_reason: str = ""  # why the tension is not to be relied on
    tension_limit: float | None = None  # [N]
    rcm_limit: float | None = None  # [m]
    age: float = 0.0  # [s]


@dataclass(frozen=True)
class UtterancePart:
    """The last decision of the recogniser."""

    transcript: str
    command: str  # that it was taken for; empty: none
    reason: str  # why it was not taken
    decided_by: str
    age: float = 0.0  # [s]


@dataclass(frozen=True)
class QuestionPart:
    """A motion that is asked for, since it was nearly sure."""

    command: str
    remaining: float  # [s] in which it can be answered


@dataclass(frozen=True)
class HearingPart:
    """What the voice node hears."""

    level: float  # [dB] of full scale, loudest since the last snapshot
    partial: str  # text as it is heard; empty: nobody speaks
    mode: str  # standby or active; empty: unknown
    microphone: str  # by name; empty: unknown
    trouble: str  # why a spoken stop may not be heard; empty: nothing
    utterance: UtterancePart | None
    question: QuestionPart | None = None
    device: str = ""  # what came of the last call to a device; empty: none was made lately
    age: float = 0.0  # [s] of the sound


@dataclass(frozen=True)
class AlarmPart:
    """What stands first; without kind: nothing."""

    kind: str = ""  # stop, fault, refusal or notice
    priority: int = 0  # 0 information, 1 low, 2 medium, 3 high
    cause: str = ""
    next_step: str = ""
    is_acknowledged: bool = False
    others: tuple[str, ...] = ()


@dataclass(frozen=True)
class RecordingPart:
    """The recorder."""

    problem: str  # why not everything is recorded; empty: it is
    file: str = ""
    since: float | None = None  # [s] that this file has been recorded for
    free: int | None = None  # [B] of its disk
    age: float = 0.0  # [s]


@dataclass(frozen=True)
class PicturePart:
    """The newest picture, which a viewer fetches when its number is another."""

    number: int
    period: float  # [s] between two of them at present
    age: float = 0.0  # [s]


@dataclass(frozen=True)
class Snapshot:
    """All parts; None: nothing has been heard of it yet."""

    time: float  # [s] since 1970
    steady: float  # [s] the same by a clock that nobody sets: how late a viewer gets it shows by it
    old_after: float  # [s]
    robot: RobotPart | None = None
    tissue: TissuePart | None = None
    hearing: HearingPart | None = None
    alarm: AlarmPart | None = None  # None: no alarm node is there and works
    recording: RecordingPart | None = None
    picture: PicturePart | None = None


@dataclass(frozen=True)
class Picture:
    """One picture of the scene, as it came."""

    number: int
    kind: str  # image/png or image/jpeg
    data: bytes
    stamp: float  # [s] when it was taken, by the camera's clock; 0: unknown

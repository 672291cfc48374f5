# SPDX-License-Identifier: BSD-3-Clause
"""What a recording holds of each trial: sound, decisions, the robot's answers and its joints."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, field
from operator import itemgetter
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from paper.judging.trials import SpokenTrial
from session_log.mcap_file.decoder import Decoder
from session_log.mcap_file.reader import SessionReader

AUDIO, JOINTS = "/voice_assist/audio", "/joint_states"
UTTERANCE, EVENT, DIAGNOSTICS = "/voice_assist/utterance", "/rst_control/event", "/diagnostics"
TISSUE = "robot: tissue"  # name of the status that says whether the tissue is triangulated
BEFORE, AFTER = 0.3, 8.0  # [s] around a trial of which the joints are kept, if no other comes
ARM = tuple(f"joint_{i}" for i in range(1, 8))
NAMES = (*ARM, "joint_pitch", "joint_finger_left", "joint_finger_right")
VERDICT = "verdict"  # key of the status in words
_TIME = itemgetter(0)

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SoundBlock:
    """One block of what the voice node heard."""

    stamp: float  # [s] when the first sample was captured
    first: int  # index of the first sample
    samples: NDArray[np.int16]  # (n,), 16 kHz mono


@dataclass(frozen=True)
class HeardDecision:
    """One decision of the recogniser."""

    time: float  # [s]
    command: str  # empty: none
    transcript: str
    reason: str  # why none was chosen
    confidence: float
    speech_end: float  # [s] as the speech detector has it


@dataclass(frozen=True)
class RecordedAnswer:
    """One entry of the controller's diary."""

    time: float  # [s]
    kind: str
    command: str
    message: str


@dataclass(frozen=True, eq=False)
class JointTrack:
    """Joint states in order of time."""

    time: Array  # (n,) [s]
    position: Array  # (n, 10) [rad]
    velocity: Array  # (n, 10) [rad/s]


@dataclass
class Recorded:
    """One session, as far as the experiment needs it."""

    sound: list[SoundBlock] = field(default_factory=list)
    decisions: list[HeardDecision] = field(default_factory=list)
    diary: list[RecordedAnswer] = field(default_factory=list)
    tissue: list[tuple[float, dict[str, str]]] = field(default_factory=list)  # [s], its status
    joints: list[tuple[float, Array, Array]] = field(default_factory=list)

    def joints_between(self, begin: float, end: float) -> JointTrack:
        """Joint states within (begin, end]."""
        first = bisect_right(self.joints, begin, key=_TIME)
        some = self.joints[first : bisect_right(self.joints, end, key=_TIME)]
        shape = (len(some), len(NAMES))
        return JointTrack(
            np.array([t for t, _, _ in some]),
            np.array([q for _, q, _ in some]).reshape(shape),
            np.array([v for _, _, v in some]).reshape(shape),
        )

    def take(self, topic: str, m: Any) -> None:
        """Keep what is needed of one decoded message."""
        if topic == AUDIO:
            samples = np.asarray(m.samples, dtype=np.int16)
            self.sound.append(SoundBlock(m.header.stamp.to_sec(), m.first_sample, samples))
        elif topic == JOINTS:
            order = [m.name.index(name) for name in NAMES]
            position, velocity = np.array(m.position)[order], np.array(m.velocity)[order]
            self.joints.append((m.header.stamp.to_sec(), position, velocity))
        elif topic == UTTERANCE:
            self.decisions.append(_decision(m))
        elif topic == EVENT:
            self.diary.append(RecordedAnswer(m.header.stamp.to_sec(), m.kind, m.command, m.message))
        elif topic == DIAGNOSTICS:
            for status in (s for s in m.status if s.name == TISSUE):
                values = {entry.key: entry.value for entry in status.values}
                values[VERDICT] = status.message
                self.tissue.append((m.header.stamp.to_sec(), values))


def read_recording(folder: Path, trials: Sequence[SpokenTrial]) -> Recorded:
    """Read a session.

    Args:
        folder: Of the session.
        trials: In order; joint states are kept around them alone.

    Raises:
        SessionMissing: There is no recording.
    """
    recorded, decoder = Recorded(), Decoder()
    begins = [trial.began - BEFORE for trial in trials]
    wanted = (AUDIO, JOINTS, UTTERANCE, EVENT, DIAGNOSTICS)
    for message in SessionReader(folder).messages(wanted):
        if message.source.topic == JOINTS:
            received = message.log_time / 1e9
            trial = bisect_right(begins, received) - 1
            if trial < 0 or received > trials[trial].ended + AFTER:
                continue
        recorded.take(message.source.topic, decoder.decode(message))
    for kept in (recorded.sound, recorded.decisions, recorded.diary):
        kept.sort(key=_stamp)
    recorded.joints.sort(key=_TIME)
    return recorded


def _decision(m: Any) -> HeardDecision:
    return HeardDecision(
        m.decision.to_sec(),
        m.command,
        m.transcript,
        m.reason,
        float(m.confidence),
        m.speech_end.to_sec(),
    )


def _stamp(kept: SoundBlock | HeardDecision | RecordedAnswer) -> float:
    return kept.stamp if isinstance(kept, SoundBlock) else kept.time

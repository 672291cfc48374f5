# SPDX-License-Identifier: BSD-3-Clause
"""What came of each phrase: what was taken, and how long decision and robot needed."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
import soundfile

from paper.config import ExperimentConfig
from paper.judging import truth
from paper.judging.recording import (
    ARM,
    HeardDecision,
    JointTrack,
    Recorded,
    RecordedAnswer,
    read_recording,
)
from paper.judging.trials import SpokenTrial, read
from paper.play.plan import MOTIONS, STOP

FILE = "outcomes.json"
LATEST = 4.0  # [s] after the end of the player in which decisions belong to a phrase
SLACK = 0.05  # [s] an answer may be stamped this much before the decision it answers
WINDOW = 0.05  # [s] before a decision over which the robot's speed is taken
SLOW = 0.002  # [rad/s] below which the robot rests and a stop has nothing to brake


@dataclass(frozen=True)
class PhraseOutcome:
    """One phrase and what came of it; times in seconds after its true end, nan where there is none.

    A decision made while the phrase still sounds has a negative time.
    """

    command: str  # meant; empty: none
    words: str
    taken: tuple[str, ...]  # commands that were heard
    transcript: str  # of the decision, or of the last one that is none
    reason: str  # why nothing was taken
    refusal: str  # the controller's; empty: none
    interrupts: str  # motion in which it was said
    is_counted: bool
    is_whole: bool  # False: the player tore the sound apart, which says nothing about the system
    decided: float  # [s]
    acted: float  # [s] the robot moves, brakes, or answers where nothing is to be moved
    rested: float  # [s] of a stop: the robot is at rest
    detected: float  # [s] where the speech detector has the end of the phrase
    sounded: float  # [s] from the start of the player to the phrase at the microphone
    confidence: float  # [0, 1] of the decision

    @property
    def is_correct(self) -> bool:
        """Whether what was meant was taken, and nothing else."""
        return self.taken == ((self.command,) if self.command else ())


def judge(folder: Path, config: ExperimentConfig) -> list[PhraseOutcome]:
    """Judge every phrase of a session, and keep that beside the recording.

    Args:
        folder: Of the session.
        config: Settings.

    Raises:
        SessionMissing: There is no recording.
    """
    trials = read(folder)
    recorded = read_recording(folder, trials)
    found = []
    for trial, following in zip(trials, [*trials[1:], None], strict=True):
        phrase, _ = soundfile.read(folder / trial.sound, dtype="float32")
        heard = truth.find(phrase, recorded.sound, trial.began, trial.ended)
        until = min(trial.ended + LATEST, following.began if following else math.inf)
        found.append(outcome(trial, heard, recorded, until, config))
    text = json.dumps([asdict(o) for o in found], indent=1)
    (folder / FILE).write_text(text + "\n", encoding="utf-8")
    return found


def kept(folder: Path) -> list[PhraseOutcome]:
    """Read the outcomes of a session that was judged; none when it was not."""
    path = folder / FILE
    if not path.is_file():
        return []
    entries = json.loads(path.read_text(encoding="utf-8"))
    return [PhraseOutcome(**{**entry, "taken": tuple(entry["taken"])}) for entry in entries]


def outcome(
    trial: SpokenTrial,
    heard: truth.Sounded | None,
    recorded: Recorded,
    until: float,
    config: ExperimentConfig,
) -> PhraseOutcome:
    """Judge one phrase.

    Args:
        trial: The phrase.
        heard: When it truly sounded; None: not whole.
        recorded: The session.
        until: Decisions later than this belong to the next phrase [s].
        config: Settings.
    """
    decisions = [d for d in recorded.decisions if trial.began <= d.time < until]
    taken = [d for d in decisions if d.command]
    shown = next(iter(taken), decisions[-1] if decisions else None)
    end = heard.end if heard else math.nan
    decision = next((d for d in taken if d.command == trial.command), None)
    answers = _answers(decision, recorded.diary)
    refusal = next((a.message for a in answers if a.kind == "refused"), "")
    acted = math.nan
    if decision and answers and not refusal:
        acted = _action(decision, answers[0], recorded, config)
    return PhraseOutcome(
        command=trial.command,
        words=trial.words,
        taken=tuple(d.command for d in taken),
        transcript=shown.transcript if shown else "",
        reason=shown.reason if shown else "nothing heard",
        refusal=refusal,
        interrupts=trial.interrupts,
        is_counted=trial.is_counted,
        is_whole=heard is not None,
        decided=decision.time - end if decision else math.nan,
        acted=acted - end,
        rested=_rest(decision, trial, recorded) - end,
        detected=decision.speech_end - end if decision else math.nan,
        sounded=heard.begin - trial.began if heard else math.nan,
        confidence=shown.confidence if shown else math.nan,
    )


def _answers(
    decision: HeardDecision | None, diary: Sequence[RecordedAnswer]
) -> list[RecordedAnswer]:
    """The controller's answers to a decision."""
    if decision is None:
        return []
    kinds = ("accepted", "refused")
    return [
        entry
        for entry in diary
        if -SLACK <= entry.time - decision.time < LATEST
        and (
            (entry.kind in kinds and entry.command == decision.command)
            or (entry.kind == "stop_received" and decision.command == STOP)
        )
    ][:1]


def _action(
    decision: HeardDecision, answer: RecordedAnswer, recorded: Recorded, config: ExperimentConfig
) -> float:
    """When the robot does what was decided [s]; nan when it is not seen to."""
    joints = recorded.joints_between(decision.time - WINDOW, decision.time + LATEST)
    if decision.command in MOTIONS:
        return first_motion(joints, decision.time, config.motion)
    if decision.command == STOP:
        return first_braking(joints, decision.time, config.braking)
    return answer.time


def first_motion(joints: JointTrack, since: float, least: float) -> float:
    """When a robot at rest has begun to move.

    Args:
        joints: Of the whole robot, from before.
        since: Moment of the decision [s].
        least: Way of a joint from where it was, that counts as motion [rad].

    Returns:
        [s]; nan when it does not.
    """
    before = joints.time <= since
    if not before.any() or before.all():
        return math.nan
    away = np.abs(joints.position - np.median(joints.position[before], axis=0)).max(axis=1)
    moved = np.flatnonzero((joints.time > since) & (away > least))
    return float(joints.time[moved[0]]) if len(moved) else math.nan


def first_braking(joints: JointTrack, since: float, share: float) -> float:
    """When a moving robot has begun to brake.

    Args:
        joints: Of the whole robot, from `WINDOW` before.
        since: Moment of the decision [s].
        share: Of the speed at that moment, below which it brakes.

    Returns:
        [s]; nan when it rested already.
    """
    speed = np.linalg.norm(joints.velocity[:, : len(ARM)], axis=1)
    before = joints.time <= since
    if not before.any():
        return math.nan
    reference = float(np.median(speed[before]))
    if reference < SLOW:
        return math.nan
    slow = np.flatnonzero((joints.time > since) & (speed < share * reference))
    return float(joints.time[slow[0]]) if len(slow) else math.nan


def _rest(decision: HeardDecision | None, trial: SpokenTrial, recorded: Recorded) -> float:
    """When a stop in a motion has brought the robot to rest [s]; nan for everything else."""
    if decision is None or decision.command != STOP or not trial.interrupts:
        return math.nan
    joints = recorded.joints_between(decision.time, decision.time + LATEST)
    speed = np.linalg.norm(joints.velocity[:, : len(ARM)], axis=1)
    fast = np.flatnonzero(speed >= SLOW)
    if not len(fast) or fast[-1] + 1 >= len(speed):
        return math.nan
    return float(joints.time[fast[-1] + 1])

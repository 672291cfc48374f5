# SPDX-License-Identifier: BSD-3-Clause
"""Values that the stages of the voice pipeline pass to each other."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from enum import Enum

import numpy as np
from numpy.typing import NDArray

RATE = 16_000  # [Hz] of all sound inside the package
LONGEST = 10.0  # [s] that a recogniser hears; of longer sound, the last part
FULL_SCALE = 32767  # of 16-bit sound

Samples = NDArray[np.float32]
IsHopeless = Callable[[str], bool]  # whether no text that begins so is worth writing to its end


def never_hopeless(beginning: str) -> bool:
    """Every text is worth writing to its end."""
    return False


def frozen_samples(samples: NDArray[np.generic]) -> Samples:
    """Copy samples to a read-only float32 array.

    Args:
        samples: Mono sound; int16 is scaled to [-1, 1]. Shape (n,).

    Returns:
        Read-only copy, float32. Shape (n,).

    Raises:
        ValueError: The array is not one-dimensional.
    """
    if samples.ndim != 1:
        raise ValueError(f"samples have shape {samples.shape}, allowed: (n,) mono")
    scale = float(FULL_SCALE) if samples.dtype == np.int16 else 1.0
    copy = np.array(samples, dtype=np.float32) / np.float32(scale)
    copy.flags.writeable = False
    return copy


@dataclass(frozen=True, eq=False)
class Frame:
    """A block of consecutive sound from one source."""

    samples: Samples  # (n,), float32 in [-1, 1], 16 kHz mono, read-only
    first_sample: int  # index of samples[0] since the stream began
    stamp: float  # [s] clock time at which samples[0] was captured
    is_moving: bool = False  # the robot moved as it was captured, or may have; see RobotMotion

    @property
    def end(self) -> float:
        """Clock time at which it ended [s]."""
        return self.stamp + self.duration

    @property
    def next_sample(self) -> int:
        """Index of the sample that follows it."""
        return self.first_sample + len(self.samples)

    @property
    def stream_end(self) -> float:
        """Its end by the count of samples [s]."""
        return self.first_sample / RATE + self.duration

    @property
    def duration(self) -> float:
        """Length of the block [s]."""
        return len(self.samples) / RATE


@dataclass(frozen=True, eq=False)
class Utterance:
    """One stretch of speech cut out by endpointing, complete or still growing."""

    samples: Samples  # (n,), float32 in [-1, 1], 16 kHz mono, read-only; raw sound
    speech_start: float  # [s] clock time of the first speech
    speech_end: float  # [s] clock time of the last speech so far
    is_complete: bool  # the end has been confirmed by silence


@dataclass(frozen=True)
class Hypothesis:
    """What a recogniser made of an utterance."""

    text: str  # as decoded, before normalisation; empty for no speech
    avg_logprob: float  # mean log-probability per token, at most 0
    no_speech_prob: float  # [0, 1]

    @property
    def confidence(self) -> float:
        """Geometric mean of the token probabilities, [0, 1]."""
        return float(np.exp(min(self.avg_logprob, 0.0)))


class Mode(Enum):
    """Whether spoken motion commands count."""

    STANDBY = "standby"
    ACTIVE = "active"


class HearingFault(Enum):
    """Why a spoken stop may not be heard.

    The value is the `reason_code` of the voice node's status in `/diagnostics`.
    """

    THREAD_ENDED = "thread_ended"
    NO_SOUND = "no_sound"
    NO_SOUND_YET = "no_sound_yet"
    MUTED = "microphone_muted"
    OVERLOADED = "microphone_overloaded"
    TORN = "sound_torn"
    CLOCKS = "clocks_apart"
    SLOW = "recognition_slow"
    HANGS = "recognition_hangs"
    SPOTTER_FAILED = "spotter_failed"  # the recogniser still hears one, here and below
    SPOTTER_SLOW = "spotter_slow"


@dataclass(frozen=True)
class Match:
    """A command was recognised."""

    command: str  # phrase, a key of commands.yaml
    wer: dict[str, float]  # WER of the transcript to every command

    def rejected(self, rejection: Rejection) -> NoMatch:
        """The same utterance where something keeps the command from being taken."""
        return NoMatch(rejection, self.command, self.wer)


class RejectionReason(Enum):
    """Why what was heard is not taken for a command.

    The value is the `reason_code` of `Utterance.msg`, for programs.
    The sentences beside it are for people.
    """

    UNSURE = "unsure"
    SOUNDS_LIKE_ANOTHER = "sounds_like_another"
    NEARLY_SURE = "nearly_sure"
    HALT_UNSURE = "halt_unsure"
    OTHER_VOICE = "other_voice"
    DAMAGED_SOUND = "damaged_sound"
    TONE = "tone"
    ROBOT_SPEAKING = "robot_speaking"
    TALK_GATE = "talk_gate"
    SAME_BREATH = "same_breath"
    SECOND_VOICE = "second_voice"
    WRONG_MODE = "wrong_mode"
    OTHER_MODE = "other_mode"
    NO_COMMAND = "no_command"


@dataclass(frozen=True)
class Rejection:
    """What keeps an utterance from being taken for a command."""

    reason: RejectionReason
    words: str  # for people


@dataclass(frozen=True)
class NoMatch:
    """No command was recognised, and why."""

    rejection: Rejection
    nearest_command: str  # by sound; empty when nothing was said
    wer: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Halt:
    """Stop the robot now, by the way that needs no answer."""


@dataclass(frozen=True)
class Call:
    """Ask the controller for a command, in its words."""

    command: str


@dataclass(frozen=True)
class Ask:
    """Ask a person whether a command was said."""

    command: str


@dataclass(frozen=True)
class SetMode:
    """The voice changed its mode."""

    mode: Mode
    reason: str


Action = Halt | Call | Ask | SetMode


@dataclass(frozen=True)
class Partial:
    """What has been heard so far of an utterance that goes on."""

    text: str  # as recognised; empty when the utterance is over or nothing was said
    stamp: float  # [s] clock time


@dataclass(frozen=True)
class Lost:
    """Sound is missing from the stream."""

    samples: int  # that were lost; 0: the stream began anew
    stamp: float  # [s] clock time of the first sample after the gap


@dataclass(frozen=True)
class UtteranceDecision:
    """What one utterance came to."""

    hypothesis: Hypothesis
    outcome: Match | NoMatch
    confidence: float  # [0, 1]
    mode: Mode  # in which it was heard
    speech_start: float  # [s] clock time
    speech_end: float  # [s] clock time of the last speech before the decision
    decided: float  # [s] clock time
    is_partial: bool  # before the end of the utterance was confirmed
    decided_by: str = "recognizer"  # or "spotter"
    actions: tuple[Action, ...] = ()  # what must now be done, in this order

    @property
    def command(self) -> str:
        """The command that was taken; empty: none."""
        return self.outcome.command if isinstance(self.outcome, Match) else ""

    @property
    def nearest_command(self) -> str:
        """That which sounds most alike, taken or not; empty when nothing was said."""
        outcome = self.outcome
        return outcome.command if isinstance(outcome, Match) else outcome.nearest_command

    @property
    def rejection(self) -> Rejection | None:
        """Why no command was taken; None: one was."""
        return None if isinstance(self.outcome, Match) else self.outcome.rejection

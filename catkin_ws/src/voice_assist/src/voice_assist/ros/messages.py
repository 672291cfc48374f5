# SPDX-License-Identifier: BSD-3-Clause
"""Values of the core to ROS messages and back."""

from __future__ import annotations

import numpy as np
import rospy
from diagnostic_msgs.msg import DiagnosticStatus
from numpy.typing import NDArray

from voice_assist.msg import AudioChunk
from voice_assist.msg import Mode as ModeMessage
from voice_assist.msg import Utterance as UtteranceMessage
from voice_assist.types import FULL_SCALE, RATE, Frame, Mode, UtteranceDecision


def audio_chunk(frame: Frame) -> AudioChunk:
    """A frame as 16-bit PCM."""
    chunk = AudioChunk(rate=RATE, first_sample=frame.first_sample)
    chunk.header.stamp = _time(frame.stamp)
    scaled = np.rint(np.clip(frame.samples, -1.0, 1.0) * FULL_SCALE)
    chunk.samples = scaled.astype(np.int16).tolist()
    return chunk


def pcm(chunk: AudioChunk) -> NDArray[np.int16]:
    """Samples of a chunk, shape (n,)."""
    return np.asarray(chunk.samples, np.int16)


def is_bad(status: DiagnosticStatus) -> bool:
    """Whether a part reports an error, or nothing any more."""
    level = status.level[0] if isinstance(status.level, bytes) else int(status.level)
    return level >= 2  # ERROR or STALE


def utterance(decision: UtteranceDecision, now: float) -> UtteranceMessage:
    """A decision with all that led to it.

    Args:
        decision: Its stamps are seconds of ROS time.
        now: Stamp of the message [s].
    """
    rejection = decision.rejection
    message = UtteranceMessage(
        transcript=decision.hypothesis.text,
        phrases=list(decision.outcome.wer),
        wer=list(decision.outcome.wer.values()),
        command=decision.command,
        reason="" if rejection is None else rejection.words,
        reason_code="" if rejection is None else rejection.reason.value,
        nearest_command=decision.nearest_command,
        confidence=decision.confidence,
        mode=decision.mode.value,
        decided_by=decision.decided_by,
        is_partial=decision.is_partial,
        speech_start=_time(decision.speech_start),
        speech_end=_time(decision.speech_end),
        decision=_time(decision.decided),
    )
    message.header.stamp = _time(now)
    return message


def mode_message(mode: Mode, reason: str, now: float) -> ModeMessage:
    """The voice mode and why it is that."""
    message = ModeMessage(mode=mode.value, reason=reason)
    message.header.stamp = _time(now)
    return message


def _time(seconds: float) -> rospy.Time:
    """Sound may have begun before a simulated clock did; there is no time before zero."""
    return rospy.Time.from_sec(max(0.0, seconds))

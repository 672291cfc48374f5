# SPDX-License-Identifier: BSD-3-Clause
"""What the node's own pipeline takes from a stretch of sound, with any recogniser in it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from voice_assist.assembly import make_pipeline
from voice_assist.audio.source import Framer
from voice_assist.config import VoiceConfig
from voice_assist.evaluation.evaluator import ClaimedCommand, claims_of, surrounded
from voice_assist.recognizer.recognizer import Recognizer
from voice_assist.types import Match, Mode, Samples, UtteranceDecision

_QUIET = 0.3, 0.8  # [s] in front of a take and behind it, so that its end is found


@dataclass(frozen=True)
class PipelineResult:
    """What a sound came to."""

    taken: tuple[str, ...]  # commands, in their order
    claims: tuple[ClaimedCommand, ...]  # decisions whose words are exactly a command's


class PipelineProbe:
    """Streams sounds through one pipeline, armed, each from a fresh start."""

    def __init__(self, config: VoiceConfig, recognizer: Recognizer) -> None:
        """Build the pipeline."""
        self._now = 0.0  # [s] of the stream; work takes no time
        self._pipeline = make_pipeline(config, lambda: self._now, recognizer)

    def __call__(self, samples: Samples) -> PipelineResult:
        """Hear a sound amid a little quiet. Shape (n,), 16 kHz."""
        self._pipeline.reset()
        began = self._now + 1.0
        taken: list[str] = []
        claims: list[ClaimedCommand] = []
        stream = surrounded(samples, np.random.default_rng(0), around=_QUIET)
        for frame in Framer().push(stream, began):
            self._pipeline.set_mode(Mode.ACTIVE, "enrolment")
            self._now = frame.end
            for decision in self._pipeline(frame):
                if isinstance(decision, UtteranceDecision):
                    claims += claims_of(decision)
                    if isinstance(decision.outcome, Match):
                        taken.append(decision.outcome.command)
        return PipelineResult(tuple(taken), tuple(claims))

# SPDX-License-Identifier: BSD-3-Clause
"""A pipeline in place of the voice part: it decides what a test plans and keeps its input."""

from __future__ import annotations

from dataclasses import dataclass, field

from session_log.replay.recorded_voice import RecordedDecision

WER = {"tense": 0.0, "stop": 1.0}


def utterance(end=1.0, **changes):
    """A decision about speech that ended at a time [s]."""
    fields = {
        "transcript": "tense",
        "wer": WER,
        "command": "tense",
        "reason": "",
        "nearest_command": "tense",
        "confidence": 0.9,
        "mode": "active",
        "decided_by": "recognizer",
        "is_partial": False,
        "speech_start": end - 0.5,
        "speech_end": end,
        "decision": end + 0.2,
    }
    return RecordedDecision(**{**fields, **changes})


@dataclass
class FakePipeline:
    """One run of the pipeline."""

    settings: dict
    notes: list
    plan: dict = field(default_factory=dict)  # decisions by the first sample of a block
    model: str = "embedded"
    model_hash: str = "ab" * 32
    spotter_hash: str = ""
    warnings: tuple = ()
    modes: list = field(default_factory=list)
    heard: list = field(default_factory=list)  # first samples

    def hear(self, sound):
        if sound.rate != 16_000:
            raise ValueError(f"rate {sound.rate} Hz, allowed: 16000")
        self.heard.append(sound.first_sample)
        return self.plan.get(sound.first_sample, [])

    def set_mode(self, mode, reason):
        self.modes.append((self.heard[-1] if self.heard else None, mode, reason))

    def heard_live(self, first_sample):
        known = [int(n.split()[1]) for n in self.notes if n.startswith("heard")]
        return first_sample < max(known, default=0)

    def lost_live(self, first_sample):
        return f"lost {first_sample}" in self.notes


MADE: list[FakePipeline] = []
PLANS: list[dict] = []  # of the runs to come


def make(settings, notes, model):
    """A MakePipeline."""
    pipeline = FakePipeline(settings, list(notes), PLANS.pop(0) if PLANS else {})
    if model is not None:
        pipeline.model, pipeline.model_hash = model, "cd" * 32
    MADE.append(pipeline)
    return pipeline

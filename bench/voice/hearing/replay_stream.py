# SPDX-License-Identifier: BSD-3-Clause
"""Sound through the node's own pipeline in lock-step, and all that it decided."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, Literal

import numpy as np

from voice_assist.assembly import make_pipeline, make_recognizer
from voice_assist.audio.robot_speech import RobotSpeechChange
from voice_assist.audio.source import FRAME, Framer
from voice_assist.config import load_voice_config
from voice_assist.evaluation.evaluator import StreamClock
from voice_assist.pipeline.pipeline import Pipeline
from voice_assist.recognizer.recognizer import Recognizer
from voice_assist.types import (
    RATE,
    Hypothesis,
    IsHopeless,
    Match,
    Mode,
    Samples,
    UtteranceDecision,
    never_hopeless,
)

Way = Literal["both", "recogniser", "spotter"]  # what listens for a stop
WAYS: tuple[Way, ...] = ("both", "recogniser", "spotter")


def way_name(way: Way) -> str:
    """A way in the name of a figure."""
    return "both ways" if way == "both" else f"{way} alone"


_IMPOSSIBLE = -1000.0  # [nat] of a phrase to who hears nothing


@dataclass(frozen=True, eq=False)
class SoundScene:
    """A stretch of sound, and how it is listened to."""

    sound: Samples  # (n,), 16 kHz in [-1, 1]
    mode: Mode  # at its beginning
    keeps_mode: bool = True  # whatever is heard, the mode stays; False: as in the node
    way: Way = "both"
    is_moving: bool = False  # the robot, all the time
    asks: bool = False  # for motions that are nearly sure
    robot_speaks: tuple[tuple[float, float], ...] = ()  # [s] from, to; reported, as a lab would


@dataclass(frozen=True)
class SceneDecision:
    """One decision."""

    at: float  # [s] in the scene, with the time to compute it
    command: str  # taken, or whose words were heard; empty: words of none
    is_taken: bool
    confidence: float  # [0, 1]
    origin: str  # "recognizer" or "spotter"
    text: str
    why: str  # refused for; empty where taken
    sure: float = -1.0  # [0, 1] the recogniser of the text; -1: from before it was kept


@dataclass(frozen=True)
class SceneResult:
    """What a scene came to."""

    said: tuple[SceneDecision, ...]
    streamed: float  # [s] of sound
    compute: float  # [s] of CPU
    armed: float  # [s] of sound heard in active mode

    @property
    def taken(self) -> tuple[str, ...]:
        """Commands taken, in their order."""
        return tuple(one.command for one in self.said if one.is_taken)

    def to_json(self) -> dict[str, Any]:
        """As JSON holds it."""
        return asdict(self)

    @staticmethod
    def from_json(data: dict[str, Any]) -> SceneResult:
        """Of what to_json gave."""
        return SceneResult(**{**data, "said": tuple(SceneDecision(**one) for one in data["said"])})


class Deaf:
    """A recogniser that hears nothing, so that only the spotter is left."""

    name, model_hash = "deaf", ""

    def transcribe(self, samples: Samples, is_hopeless: IsHopeless = never_hopeless) -> Hypothesis:
        """Nothing."""
        return Hypothesis("", 0.0, 1.0)

    def score(self, samples: Samples, phrases: Sequence[str]) -> dict[str, float]:
        """Every phrase is impossible."""
        return dict.fromkeys(phrases, _IMPOSSIBLE)

    def verify(self, samples: Samples, phrase: str) -> float:
        """It is not that phrase."""
        return _IMPOSSIBLE


class SceneListener:
    """Streams scenes, one pipeline per way. A question counts as a refusal, but where a scene asks.

    Time is the stream's plus the CPU time of the work, so that what else runs on the machine
    lengthens nothing.
    """

    def __init__(self, model: str, **changes: Any) -> None:
        """Load the recogniser once; it must be loadable under that name.

        Args:
            model: That listens.
            **changes: Of the settings, as `load_voice_config` takes them.
        """
        unasked = {"recognizer__ask__is_enabled": False}
        self._changes: dict[str, Any] = {"recognizer__model": model, **unasked, **changes}
        self._config = load_voice_config(**self._changes)
        self._recognizer = make_recognizer(self._config)
        self._clock = StreamClock(time.process_time)
        self._pipelines: dict[tuple[Way, bool], Pipeline] = {}

    def __call__(self, scene: SoundScene) -> SceneResult:
        """Stream a scene from a fresh start."""
        pipeline = self._pipeline(scene.way, scene.asks)
        pipeline.reset()
        pipeline.set_mode(scene.mode, "bench")
        began, compute = self._clock() + 1.0, self._clock.compute
        said: list[SceneDecision] = []
        armed = 0
        changes = [(began + at, i == 0) for span in scene.robot_speaks for i, at in enumerate(span)]
        for frame in Framer().push(whole_frames(scene.sound), began):
            if scene.keeps_mode:
                pipeline.set_mode(scene.mode, "bench")
            while changes and changes[0][0] < frame.stamp + frame.duration:
                at, is_speaking = changes.pop(0)
                pipeline.robot_spoke(RobotSpeechChange(is_speaking, at))
            armed += pipeline.state.mode is Mode.ACTIVE
            self._clock.begin(frame.stamp + frame.duration)
            events = pipeline(replace(frame, is_moving=scene.is_moving))
            self._clock.end()
            said += [
                _said(event, began) for event in events if isinstance(event, UtteranceDecision)
            ]
        streamed = len(whole_frames(scene.sound)) / RATE
        spent = self._clock.compute - compute
        return SceneResult(tuple(said), streamed, spent, armed * FRAME / RATE)

    def _pipeline(self, way: Way, asks: bool) -> Pipeline:
        if (way, asks) not in self._pipelines:
            config = self._config
            if way == "recogniser" or asks:
                changes = self._changes | {"recognizer__ask__is_enabled": asks}
                config = load_voice_config(spotter__is_enabled=way != "recogniser", **changes)
            recognizer: Recognizer = Deaf() if way == "spotter" else self._recognizer
            pipeline = make_pipeline(config, self._clock, recognizer)
            noise = np.random.default_rng(0).standard_normal(2 * RATE)
            pipeline.warm_up((0.1 * noise).astype(np.float32))
            self._pipelines[way, asks] = pipeline
        return self._pipelines[way, asks]


def whole_frames(sound: Samples) -> Samples:
    """Sound with silence behind it to whole frames. From shape (n,) to (m,), m >= n."""
    return np.pad(sound, (0, -len(sound) % FRAME))


def _said(decision: UtteranceDecision, began: float) -> SceneDecision:
    outcome = decision.outcome
    is_taken = isinstance(outcome, Match)
    command, why = "", ""
    if isinstance(outcome, Match):
        command = outcome.command
    else:
        why = outcome.rejection.words
        if outcome.wer.get(outcome.nearest_command) == 0.0:
            command = outcome.nearest_command
    return SceneDecision(
        round(decision.decided - began, 4),
        command,
        is_taken,
        round(decision.confidence, 4),
        decision.decided_by,
        decision.hypothesis.text,
        why,
        round(decision.hypothesis.confidence, 4),
    )

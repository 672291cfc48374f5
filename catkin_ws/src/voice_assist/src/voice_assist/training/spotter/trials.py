# SPDX-License-Identifier: BSD-3-Clause
"""What recogniser and spotter each believe of clips, once for all thresholds."""

from __future__ import annotations

import json
import logging
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path

import numpy as np
import torch

from voice_assist.assembly import make_spotter
from voice_assist.audio.mixing import end_of_speech
from voice_assist.audio.source import Framer
from voice_assist.config import SpotterConfig, VoiceConfig
from voice_assist.evaluation.evaluator import BEFORE, surrounded
from voice_assist.pipeline.pipeline import Pipeline
from voice_assist.recognizer.recognizer import Recognizer
from voice_assist.spotter.fusion import StopEvidence, StopFusion
from voice_assist.spotter.head import CONTEXT, read_head
from voice_assist.spotter.spotter import Spotter
from voice_assist.training.array_file import write_json
from voice_assist.training.cache_key import digest, keyed
from voice_assist.training.spotter.embed import LongEmbedder
from voice_assist.types import FULL_SCALE, RATE, Mode, Samples
from voice_assist.vad.detector import make_detector

LOG = logging.getLogger("spotter")
NEVER = 1000.0  # [nat]
EVIDENCE = [field.name for field in fields(StopEvidence)]  # trials with other evidence run anew


@dataclass(frozen=True)
class TrialEvidence:
    """One moment at which the recogniser could lead to a stop."""

    time: float  # [s] from the begin of the clip
    spotted: float  # [nat] the spotter's recent best
    confidence: float  # [0, 1] with which it wrote the word; below 0: it wrote something else
    is_ready: bool  # see StopEvidence
    is_last: bool  # see StopEvidence
    ratio: float  # [nat] of the word where it wrote something else


@dataclass(frozen=True)
class SpotterTrial:
    """What one clip came to, with nothing fired."""

    name: str
    seconds: float  # of the clip, without the quiet around it
    speech_end: float  # [s] from its begin
    weight: float  # clips that it stands for
    heard: tuple[TrialEvidence, ...]
    looks: tuple[tuple[float, float], ...]  # time [s] from the begin of the clip, score [nat]


class EvidenceRecorder(StopFusion):
    """Writes down what it is asked, and never fires."""

    def __init__(self, config: SpotterConfig, spotter: Spotter, floor: float) -> None:
        """Listen with a spotter that is set never to fire alone.

        Args:
            config: Its settings.
            spotter: The real one.
            floor: Of its score, from which the recogniser's ratio is computed at all [nat].
        """
        super().__init__(config, spotter)
        self._floor = floor
        self.heard: list[TrialEvidence] = []
        self._now = 0.0

    def best(self, now: float) -> float | None:
        """See StopFusion; keeps the moment."""
        self._now = now
        return super().best(now)

    def confirms(self, evidence: StopEvidence, phrase: str) -> bool:
        """Keep what the recogniser believes of the word."""
        if phrase == self.phrase:
            spotted = _finite(evidence.spotted)
            written = evidence.confidence, evidence.is_ready, evidence.is_last
            self.heard.append(TrialEvidence(self._now, spotted, *written, NEVER))
        return False

    def is_asking(self, spotted: float | None) -> bool:
        """Ask from very little belief on."""
        return spotted is not None and spotted >= self._floor

    def overrules(self, spotted: float | None, ratio: float) -> bool:
        """Keep how likely the word is to the recogniser."""
        other = -1.0, False, False, float(ratio)
        self.heard.append(TrialEvidence(self._now, _finite(spotted), *other))
        return False


class TrialRunner:
    """Runs clips through the real pipeline with a recorder in place of the rule."""

    def __init__(
        self, config: VoiceConfig, recognizer: Recognizer, cache: Path, floor: float
    ) -> None:
        """Build it.

        Args:
            config: Its thresholds of the spotter have no effect.
            recognizer: The one to tune for.
            cache: Folder for what was found, by the models, the settings and the clips.
            floor: Score of the spotter below which it believes nothing [nat].
        """
        spotter_config = replace(config.spotter, alone=NEVER)
        self._spotter, spotter_sha256 = make_spotter(spotter_config)
        self._recorder = EvidenceRecorder(spotter_config, self._spotter, floor)
        self._pipeline = Pipeline(
            config, recognizer, make_detector(config.audio.vad), lambda: 0.0, self._recorder
        )
        self._head, self._embed = read_head()[0], LongEmbedder()
        self._cache, self._floor = cache, floor
        no_threshold = replace(spotter_config, middle=NEVER, near=NEVER, agree=NEVER, sure=1.0)
        settings = {**vars(config), "spotter": no_threshold}
        self._key = digest(recognizer.model_hash, spotter_sha256, floor, EVIDENCE, settings)

    def __call__(
        self,
        name: str,
        clips: Sequence[tuple[str, Samples]],
        noises: Sequence[Samples] = (),
        snr: float = 0.0,
        thin: int = 1,
    ) -> list[SpotterTrial]:
        """Trials of a named set, from the cache where it was run before.

        Args:
            name: Of the set, in the name of its file.
            clips: Each with a name.
            noises: One of them is added to each clip.
            snr: Level of the clip over it [dB].
            thin: Of the clips in which the spotter believes nothing, of which only the recogniser
                alone could make a stop, one in so many is run, and stands for the others.
        """
        path = keyed(self._cache / f"{name}.json", self._key, clips, noises, snr, thin)
        if not path.is_file():
            write_json(path, [asdict(t) for t in self._run(clips, noises, snr, thin)])
        return [_trial(entry) for entry in json.loads(path.read_text(encoding="utf-8"))]

    def _run(
        self, clips: Iterable[tuple[str, Samples]], noises: Sequence[Samples], snr: float, thin: int
    ) -> Iterator[SpotterTrial]:
        for number, (name, samples) in enumerate(clips):
            stream = surrounded(samples, np.random.default_rng(number), noises, snr)
            weight = thin if thin > 1 and self._best(stream) < self._floor else 1
            if number % weight:
                continue
            self._pipeline.reset()
            self._recorder.heard.clear()
            looks: list[tuple[float, float]] = []
            for frame in Framer().push(stream, 0.0):
                self._pipeline.set_mode(Mode.ACTIVE, "trial")
                self._pipeline(frame)
                newest = self._spotter.scores[-1:]
                if newest and (not looks or newest[0].time - BEFORE != looks[-1][0]):
                    looks.append((newest[0].time - BEFORE, newest[0].score))
            heard = tuple(replace(h, time=h.time - BEFORE) for h in self._recorder.heard)
            seconds = len(samples) / RATE
            end = end_of_speech(samples)
            yield SpotterTrial(name, seconds, end, float(weight), heard, tuple(looks))

    def _best(self, stream: Samples) -> float:
        """The spotter's highest score in a stream."""
        quiet = np.tile(self._embed.quiet, (CONTEXT - 1, 1))
        seen = np.concatenate([quiet, self._embed(stream)])
        looks = np.lib.stride_tricks.sliding_window_view(seen, CONTEXT, 0).transpose(0, 2, 1)
        with torch.inference_mode():
            scores = self._head(torch.from_numpy(looks.copy()))
        return float(((scores[1:] + scores[:-1]) / 2).max())


def as_float(samples: np.ndarray) -> Samples:
    """16-bit sound to [-1, 1]."""
    return np.asarray(samples, np.float32) / np.float32(FULL_SCALE)


def _finite(score: float | None) -> float:
    return -NEVER if score is None else max(score, -NEVER)


def _trial(entry: dict[str, object]) -> SpotterTrial:
    heard = tuple(TrialEvidence(**h) for h in entry.pop("heard"))  # type: ignore[attr-defined]
    looks = tuple((time, score) for time, score in entry.pop("looks"))  # type: ignore[attr-defined]
    return SpotterTrial(**entry, heard=heard, looks=looks)  # type: ignore[arg-type]

# SPDX-License-Identifier: BSD-3-Clause
"""Listens for one word in a stream; fires once when it is sure, and keeps what it heard."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np

from voice_assist.config import SpotterConfig
from voice_assist.types import Frame, Samples

if TYPE_CHECKING:
    from voice_assist.spotter.features import Embeddings

_KEPT = 256  # scores, 20 s: more than the recogniser's queue can hold it back
NEWEST = 1 << 62  # a sample that no stream reaches

Score = Callable[["Embeddings"], float]  # of (CONTEXT, WIDTH) embeddings, oldest first: log-odds


@dataclass(frozen=True)
class SpotterScore:
    """The score of 80 ms of sound."""

    time: float  # [s] clock time at which the sound it is about ended
    score: float  # [nat] log-odds that the word has just ended, mean of the two newest
    until: int  # index of the sample that follows that sound


@dataclass(frozen=True)
class Spotted:
    """The word was heard surely enough for the spotter to act alone."""

    time: float  # [s] clock time at which the sound it is about ended
    score: float  # [nat]
    is_sent: bool = False  # the stop was sent already by the thread of the spotter


class Frontend(Protocol):
    """Features of a stream, one for every 80 ms, whatever the blocks it comes in."""

    quiet: Embeddings  # that of silence

    def reset(self) -> None:
        """Begin a new stream."""

    def __call__(self, samples: Samples) -> Iterator[Embeddings]:
        """Take the next samples, shape (n,), within [-1, 1]."""


class Spotting(Protocol):
    """A spotter as the pipeline sees it, wherever it runs."""

    def __call__(self, frame: Frame) -> Spotted | None:
        """What was spotted since the last call; each is given once."""

    def best(self, since: float, until: int = NEWEST) -> float | None:
        """Highest score since a clock time [s]; None: nobody listens.

        Args:
            since: Clock time [s].
            until: Index of the first sample that counts no more.
        """

    def reset(self) -> None:
        """Forget the stream so far."""


class Spotter:
    """Scores every 80 ms of sound, whatever the frames it comes in.

    What it fires stays latched: it fires again only once the score has been below the threshold
    for `rearm_after`. `best` may be asked from another thread.
    """

    def __init__(
        self,
        config: SpotterConfig,
        frontend: Frontend,
        score: Score,
        context: int,
        alone_in_motion: float | None = None,
    ) -> None:
        """Start with a silent past.

        Args:
            config: When to fire.
            frontend: Makes embeddings of sound, or cuts windows out of it.
            score: The trained head.
            context: Embeddings that it sees.
            alone_in_motion: Score from which it fires while the robot moves, if lower [nat]; None:
                as at rest.
        """
        least = config.alone if alone_in_motion is None else min(alone_in_motion, config.alone)
        self._alone_in_motion = least
        self._config, self._frontend, self._score, self._context = config, frontend, score, context
        self._lock = threading.Lock()
        self._next_sample: int | None = None
        self.reset()

    def reset(self) -> None:
        """Forget the stream so far, and what was fired."""
        with self._lock:
            self._scores: deque[SpotterScore] = deque(maxlen=_KEPT)
        self._latched_until = float("-inf")  # [s] clock time
        self._restart()

    def __call__(self, frame: Frame) -> Spotted | None:
        """Hear a frame; gives what it fires with it. A gap before the frame is heard as silence."""
        if self._next_sample is not None and frame.first_sample != self._next_sample:
            self._restart()
        self._next_sample = frame.next_sample
        fired = None
        for embedding in self._frontend(frame.samples):
            fired = self._update(embedding, frame) or fired
        return fired

    @property
    def scores(self) -> tuple[SpotterScore, ...]:
        """The newest scores, oldest first."""
        with self._lock:
            return tuple(self._scores)

    def best(self, since: float, until: int = NEWEST) -> float | None:
        """Highest score since a clock time; minus infinity where there was none."""
        found = [s.score for s in self.scores if s.time >= since and s.until <= until]
        return max(found, default=float("-inf"))

    def _restart(self) -> None:
        self._frontend.reset()
        self._seen: deque[Embeddings] = deque(
            [self._frontend.quiet] * self._context, maxlen=self._context
        )
        self._before: float | None = None
        self._next_sample = None

    def _update(self, embedding: Embeddings, frame: Frame) -> Spotted | None:
        time = frame.end
        self._seen.append(embedding)
        newest = self._score(np.stack(self._seen))
        score = newest if self._before is None else (newest + self._before) / 2
        self._before = newest
        with self._lock:
            self._scores.append(SpotterScore(time, score, self._next_sample or 0))
        if score < (self._alone_in_motion if frame.is_moving else self._config.alone):
            return None
        left = self._latched_until - time
        is_latched = 0.0 < left <= self._config.rearm_after  # more: the clock was set back
        self._latched_until = time + self._config.rearm_after
        return None if is_latched else Spotted(time, score)

# SPDX-License-Identifier: BSD-3-Clause
"""Applies thresholds of the rule to recorded trials, and chooses them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from voice_assist.config import SpotterConfig
from voice_assist.errors import VoiceError
from voice_assist.evaluation.exact_bounds import share_interval
from voice_assist.spotter.fusion import StopEvidence, StopFusion
from voice_assist.training.spotter.trials import NEVER, SpotterTrial

_SURE = (0.7, 0.75, 0.8, 0.85, 0.9, 0.95)
_NEAR = (-NEVER, 0.0, 4.0)  # the first: rule 4 never
_QUANTILES = 8  # thresholds of the spotter to try
_IN_TIME = 0.3  # [s] after the word; what comes later counts as not heard


@dataclass(frozen=True)
class Count:
    """How many of so many, with an exact interval."""

    found: int
    of: int

    @property
    def share(self) -> float:
        """Of all."""
        return self.found / self.of if self.of else float("nan")

    @property
    def interval(self) -> tuple[float, float]:
        """95 %, two-sided and exact."""
        return share_interval(self.found, self.of)

    def __str__(self) -> str:
        low, high = self.interval
        return f"{self.found}/{self.of} = {self.share:.1%} ({low:.1%} to {high:.1%})"


def fired_at(trial: SpotterTrial, config: SpotterConfig) -> float | None:
    """Time of the stop that a clip leads to [s] from its begin; None: none."""
    rule = StopFusion(config, None)
    times = [time for time, score in trial.looks if score >= config.alone][:1]
    for heard in trial.heard:
        if heard.confidence < 0.0:
            fires = rule.overrules(heard.spotted, heard.ratio)
        else:
            belief = StopEvidence(heard.confidence, heard.is_ready, heard.is_last, heard.spotted)
            fires = rule.confirms(belief, config.phrase)
        if fires:
            times.append(heard.time)
            break
    return min(times, default=None)


def fired(trials: Sequence[SpotterTrial], config: SpotterConfig) -> Count:
    """Clips that lead to a stop."""
    return Count(sum(fired_at(t, config) is not None for t in trials), len(trials))


def false_stops(talk: Sequence[SpotterTrial], config: SpotterConfig) -> float:
    """Clips with a stop, each counted as those that it stands for."""
    return sum(t.weight for t in talk if fired_at(t, config) is not None)


def hours(talk: Sequence[SpotterTrial]) -> float:
    """Length of the clips, without the quiet around them [h]."""
    return sum(t.weight * t.seconds for t in talk) / 3600.0


def latencies(trials: Sequence[SpotterTrial], config: SpotterConfig) -> list[float]:
    """Of those that stop, from the end of speech [s], without the time of computing."""
    pairs = [(fired_at(t, config), t.speech_end) for t in trials]
    return [time - end for time, end in pairs if time is not None]


def recogniser_alone(config: SpotterConfig) -> SpotterConfig:
    """The rule as it is where no spotter listens."""
    return replace(config, alone=NEVER, middle=NEVER, agree=NEVER, sure=0.0)


def spotter_alone(config: SpotterConfig, threshold: float) -> SpotterConfig:
    """Rule 1 alone, with a threshold."""
    return replace(config, alone=threshold, middle=NEVER, agree=NEVER, sure=1.01)


def thresholds(talk: Sequence[SpotterTrial], rates: Sequence[float]) -> dict[float, float]:
    """For each rate of false stops per hour the spotter's threshold that just keeps it."""
    best = np.sort([max((s for _, s in t.looks), default=-NEVER) for t in talk])[::-1]
    places = {rate: min(int(rate * hours(talk)), len(best) - 1) for rate in rates}
    return {rate: float(best[place]) + 0.01 for rate, place in places.items()}


def choose(
    config: SpotterConfig,
    said: Mapping[str, Sequence[SpotterTrial]],
    weights: Mapping[str, float],
    talk: Sequence[SpotterTrial],
    alone_rate: float,
    rate: float,
) -> SpotterConfig:
    """Thresholds with the highest weighted recall in time within a rate of false stops.

    Of equals the one with fewer false stops, and of those the quickest.

    Args:
        config: Gives all that is not chosen.
        said: Sets in which the word was said.
        weights: Of those sets.
        talk: In which it was not.
        alone_rate: False stops per hour that the spotter may cause by itself.
        rate: And both together.

    Raises:
        VoiceError: No thresholds keep that rate.
    """
    alone = max(thresholds(talk, [alone_rate])[alone_rate], 0.0)
    allowed = rate * hours(talk)
    suspects = [t for t in talk if _could_fire(t)]
    best: tuple[float, float, float, SpotterConfig] | None = None
    for tried in _candidates(replace(config, alone=alone), said):
        false = false_stops(suspects, tried)
        if false > allowed:
            continue
        late = {name: latencies(said[name], tried) for name in weights}
        recall = sum(w * _in_time(late[name]) / len(said[name]) for name, w in weights.items())
        rank = (recall, -false, -sum(w * sum(late[name]) for name, w in weights.items()))
        if best is None or rank > best[:3]:
            best = (*rank, tried)
    if best is None:
        raise VoiceError(f"no thresholds keep {rate} false stops per hour")
    return best[3]


def _in_time(late: Sequence[float]) -> int:
    return sum(time <= _IN_TIME for time in late)


def _candidates(
    config: SpotterConfig, said: Mapping[str, Sequence[SpotterTrial]]
) -> Iterator[SpotterConfig]:
    best = [max(s for _, s in t.looks) for trials in said.values() for t in trials]
    levels = np.unique(np.round(np.quantile(best, np.linspace(0.0, 0.5, _QUANTILES)), 1))
    for agree, middle in product(levels, levels):
        if agree <= middle <= config.alone:
            for sure, near in product(_SURE, _NEAR):
                yield replace(config, agree=agree, middle=middle, sure=sure, near=near)


def _could_fire(trial: SpotterTrial) -> bool:
    return bool(trial.heard) or max((s for _, s in trial.looks), default=-NEVER) > 0.0

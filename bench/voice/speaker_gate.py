# SPDX-License-Identifier: BSD-3-Clause
"""`make bench ONLY=speaker`: how well the speaker gate separates voices that it never heard.

Speakers of the splits `dev` and `false_accept_dev` of ../shared/speech; of each the first half of
the recordings enrols and the second is tried, against its own voiceprint and those of all others
of the same source, so that no channel gives a speaker away.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from bench.voice.material.clips import SPEECH
from support.figures import Figure, over_groups, share
from support.theatre_sound import theatre_noise
from voice_assist.audio.mixing import add_noise
from voice_assist.config import load_voice_config
from voice_assist.evaluation.exact_bounds import share_interval
from voice_assist.speaker.cohort import Cohort, read_cohort
from voice_assist.speaker.network import PIECE, WIDTH, Vector, VoiceNetwork, unit
from voice_assist.speaker.speech import piece_up, spoken
from voice_assist.speaker.voiceprint import Voiceprint, VoiceprintError, make_voiceprint
from voice_assist.training.speaker_cohort import speech_of
from voice_assist.types import RATE, Samples

LENGTHS = (0.5, 1.0, 2.0)  # [s] of speech; commands have 0.4 to 0.9
MAX_UTTERANCES = 6  # utterances of each length and speaker
POOLED = 3  # utterances of 1 s that are judged together
ENROLLED = 10.0  # [s] at most
TAKE = 1.0  # [s] of one take
ENOUGH = 3.0  # [s] enrolled is enough here: the recordings are short
SNR = 10.0  # [dB] of speech over a theatre's noise, in the last row
WORST = 5.0  # [%] target
LIBRI, WORDS = "resemble-ai/Resemblyzer", "thegtagamer/PICO-tinyML-benchmark"

Scores = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class GateSpeaker:
    """One that the gate never heard."""

    source: str
    enrolled: list[Samples]
    tried: dict[float, list[Samples]]  # by length [s]
    centre: Vector = field(default_factory=lambda: np.zeros(WIDTH))  # of what was enrolled
    points: dict[float, list[Vector]] = field(default_factory=dict)  # of what was tried
    noisy: list[Vector] = field(default_factory=list)  # of what was tried for 1 s, in noise


@dataclass(frozen=True, eq=False)
class Trials:
    """Scores of utterances in the right voice and in others [standard deviations]."""

    own: tuple[Scores, ...]  # of each speaker
    other: Scores

    @property
    def equal_error(self) -> tuple[float, float]:
        """Rate at which misses and false accepts are as frequent, and the threshold there."""
        own = np.sort(np.concatenate(self.own))
        steps = np.unique(np.concatenate([own, self.other]))
        missed = np.searchsorted(own, steps) / len(own)
        let_in = 1.0 - np.searchsorted(np.sort(self.other), steps) / len(self.other)
        at = int(np.abs(missed - let_in).argmin())
        return float(missed[at] + let_in[at]) / 2.0, float(steps[at])


def measure() -> list[Figure]:
    """Equal error rates by length, noise and pooling; what a profile's threshold does; cost."""
    embed, (cohort, digest) = _Memory(), read_cohort()
    speakers = [_heard(speaker, embed) for speaker in _speakers()]
    figures: list[Figure] = []
    for seconds in LENGTHS:
        heard = [s.points[seconds] for s in speakers]
        figures += _rates(f"all, {seconds:g} s", _trials(speakers, heard, cohort))
    for name, source in (("read books", LIBRI), ("single words", WORDS)):
        group = [s for s in speakers if s.source == source]
        for seconds in LENGTHS[:2]:
            heard = [s.points[seconds] for s in group]
            figures += _rates(f"{name}, {seconds:g} s", _trials(group, heard, cohort))
    pooled = _trials(speakers, [_pooled(s.points[1.0]) for s in speakers], cohort)
    figures += _rates(f"all, {POOLED} utterances of 1 s pooled", pooled)
    noisy = _trials(speakers, [s.noisy for s in speakers], cohort)
    figures += _rates(f"all, 1 s in a theatre's noise at {SNR:g} dB", noisy)
    return [*figures, *_profiles(speakers, embed, cohort, digest), *_cost(speakers, cohort)]


class _Memory:
    """The network, with what it heard in one batch."""

    def __init__(self) -> None:
        self._network, self._known = VoiceNetwork(), dict[bytes, Vector]()

    def listen(self, speeches: Sequence[Samples]) -> list[Vector]:
        """Embed several utterances and remember them."""
        points = list(self._network.many(speeches))
        known = zip(speeches, points, strict=True)
        self._known |= {speech.tobytes(): point for speech, point in known}
        return points

    def __call__(self, speech: Samples) -> Vector:
        known = self._known.get(speech.tobytes())
        return self._network(speech) if known is None else known


def _heard(speaker: GateSpeaker, embed: _Memory) -> GateSpeaker:
    """The same with all embeddings that are needed, each computed once."""
    takes = [p for take in speaker.enrolled for p in piece_up(spoken(take), PIECE)]
    return replace(
        speaker,
        centre=unit(np.mean(embed.listen(takes), axis=0)),
        points={n: embed.listen(tried) for n, tried in speaker.tried.items()},
        noisy=embed.listen([_noisy(u, n) for n, u in enumerate(speaker.tried[1.0])]),
    )


def _speakers() -> Iterator[GateSpeaker]:
    for (source, _), clips in speech_of(SPEECH, ("dev", "false_accept_dev")):
        first, rest = _halves(clips)
        enrolled = _cut(first[: round(ENROLLED * RATE)], TAKE)
        tried = {seconds: _cut(rest, seconds)[:MAX_UTTERANCES] for seconds in LENGTHS}
        if len(enrolled) >= 2 and tried[1.0]:
            yield GateSpeaker(source, enrolled, tried)


def _halves(clips: Sequence[Samples]) -> tuple[Samples, Samples]:
    """Sound of the first clips and that of the others; one long recording is cut in two."""
    count = int((np.cumsum([len(c) for c in clips]) <= sum(map(len, clips)) / 2).sum())
    if count == 0:
        whole = np.concatenate(clips)
        return whole[: len(whole) // 2], whole[len(whole) // 2 :]
    return np.concatenate(clips[:count]), np.concatenate(clips[count:])


def _cut(sound: Samples, seconds: float) -> list[Samples]:
    n = round(seconds * RATE)
    return [sound[at : at + n] for at in range(0, len(sound) - n + 1, n)]


def _pooled(heard: Sequence[Vector]) -> list[Vector]:
    ends = range(POOLED, len(heard) + 1, POOLED)
    return [unit(np.mean(heard[end - POOLED : end], axis=0)) for end in ends]


def _noisy(sound: Samples, seed: int) -> Samples:
    noise = theatre_noise(len(sound) / RATE + 0.1, 0.1, seed=seed).astype(np.float32)
    mixed = add_noise(sound.astype(np.float64), noise, sound, SNR, np.random.default_rng(seed))
    return mixed.astype(np.float32)


def _trials(
    group: Sequence[GateSpeaker], heard: Sequence[Sequence[Vector]], cohort: Cohort
) -> Trials:
    """Every utterance against every voice of its own source."""
    own: list[Scores] = []
    other: list[float] = []
    rows, sources = np.stack([s.centre for s in group]), [s.source for s in group]
    for index, points in enumerate(heard):
        rivals = [n for n, s in enumerate(sources) if s == sources[index] and n != index]
        scores = [cohort.score(point, rows) for point in points]
        other += [float(one) for each in scores for one in each[rivals]]
        if scores:
            own.append(np.array([each[index] for each in scores]))
    return Trials(tuple(own), np.array(other))


def _rates(name: str, trials: Trials) -> list[Figure]:
    rate, threshold = trials.equal_error
    groups = [(int((own < threshold).sum()), len(own)) for own in trials.own]
    missed, count = map(sum, zip(*groups, strict=True))
    note = f"{len(groups)} speakers, {count} own and {len(trials.other)} other trials"
    low, high = share_interval(missed, count)
    if len(groups) > 1:
        low = min(low, over_groups(groups, 0.025))
        high = max(high, over_groups(groups, 0.975))
    bounds = 100 * low, 100 * high
    return [Figure(f"equal error: {name}", 100.0 * rate, "%", WORST, True, note, *bounds)]


def _profiles(
    speakers: Sequence[GateSpeaker], embed: _Memory, cohort: Cohort, digest: str
) -> list[Figure]:
    """What happens at each voiceprint's own threshold."""
    config = load_voice_config(speaker__gate="on", speaker__min_enrolled=ENOUGH).speaker
    of_each = len(speakers), 4  # own, missed, other, let in
    counts = {seconds: np.zeros(of_each, int) for seconds in LENGTHS[:2]}
    known: dict[int, Voiceprint] = {}
    refused: Counter[str] = Counter()
    for index, speaker in enumerate(speakers):
        try:
            known[index] = make_voiceprint(speaker.enrolled, embed, cohort, digest, config)
        except VoiceprintError as error:
            refused["unlike itself" if "refuse" in str(error) else "too short"] += 1
    rows = np.stack([v.centre for v in known.values()])
    limits = np.array([v.threshold for v in known.values()])
    for seconds, count in counts.items():
        for index, speaker in enumerate(speakers):
            own = np.array([n == index for n in known])
            rival = np.array([speakers[n].source == speaker.source for n in known]) & ~own
            for point in speaker.points[seconds]:
                passed = cohort.score(point, rows) >= limits
                found = own, own & ~passed, rival, rival & passed
                count[index] += np.array([kind.sum() for kind in found])
    note = f"(of {len(speakers)}; refused: {dict(refused)})"
    figures = [Figure("voiceprints made", len(known), "", note=note)]
    for seconds, count in counts.items():
        for what, n, k in (("own voice refused", 0, 1), ("other let in", 2, 3)):
            groups = [(int(one[k]), int(one[n])) for one in count if one[n]]
            some, trials = (sum(column) for column in zip(*groups, strict=True))
            name = f"at its threshold, {seconds:g} s: {what}"
            figures.append(share(name, some, trials, at_most=True, groups=groups))
    return figures


def _cost(speakers: Sequence[GateSpeaker], cohort: Cohort) -> list[Figure]:
    embed, times = VoiceNetwork(), []
    for speaker in speakers[:60]:
        begin = time.perf_counter()
        cohort.score(embed(speaker.tried[1.0][0]), speaker.centre)
        times.append(1e3 * (time.perf_counter() - begin))
    return [Figure("gate, 1 s of speech, p50", float(np.median(times)), "ms")]

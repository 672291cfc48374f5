# SPDX-License-Identifier: BSD-3-Clause
"""People who said "stop" more than once: each clip heard by what was learned from the others.

The recordings hold no other command by the same person, so only "stop" is enrolled; what of it is
lost or gained elsewhere is counted on the person's other words.
"""

from __future__ import annotations

import json
import time
from collections import defaultdict
from dataclasses import dataclass

from bench.common.resumable import MINUTES, share_of
from bench.enrolment import pieces
from bench.enrolment.cast import EnrolledSpeech
from bench.voice.material.synthesis import DEV, SpokenClip, recorded
from session_log.report.bounds import at_most
from support.figures import ROOT, Figure
from voice_assist.audio.wav_file import read_sound
from voice_assist.enrolment.learn import learn
from voice_assist.enrolment.pipeline_probe import PipelineProbe
from voice_assist.profile.active import PersonalRecognizer

WORD = "stop"
_WORDS = 6  # other words of each person


@dataclass(frozen=True)
class Person:
    """One speaker, clip by clip."""

    name: str
    clips: int
    base: int  # of them taken by the base
    profile: int
    words: int  # other words
    base_false: int  # of them taken for a command
    profile_false: int


def measure(began: float) -> list[Figure]:
    """All people of the split `dev`, or as many as there is time for.

    Args:
        began: When the whole measurement did, by the steady clock [s].
    """
    said: dict[str, list[SpokenClip]] = defaultdict(list)
    for clip in recorded(DEV):
        said[clip.voice].append(clip)
    speakers = [
        name for name, clips in sorted(said.items()) if sum(c.text == WORD for c in clips) > 1
    ]
    if not speakers:
        print("no human speech in ../shared/speech: people left out")
        return []
    found = []
    for name in share_of(speakers):
        path = pieces.FOLDER / pieces.key() / f"human-{name}.json"
        if not path.is_file():
            if time.monotonic() - began > 60.0 * MINUTES:
                continue
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(json.dumps(_one(name, said[name]).__dict__), encoding="utf-8")
        found.append(Person(**json.loads(path.read_text(encoding="utf-8"))))
    return _figures(found)


def _one(name: str, clips: list[SpokenClip]) -> Person:
    shared = pieces.bench()
    stops = [_said(c) for c in clips if c.text == WORD]
    words = [_said(c) for c in clips if c.text != WORD][:_WORDS]
    base, phrases = PipelineProbe(shared.voice, shared.base), shared.voice.commands.phrases
    before, false = pieces.count(base, stops, phrases), pieces.count(base, words, phrases)
    right = profile_false = 0
    folds = min(len(stops), 2)
    for fold in range(folds):
        rest = [stop for i, stop in enumerate(stops) if i % folds != fold]
        left = [stop for i, stop in enumerate(stops) if i % folds == fold]
        material = pieces.spoken(rest, [])
        state = learn(shared.base, material, shared.others, shared.config.adapt).state
        ear = PipelineProbe(shared.voice, PersonalRecognizer(shared.base, state))
        right += pieces.count(ear, left, phrases).right
        if fold == 0:
            profile_false = pieces.count(ear, words, phrases).another
    return Person(name, len(stops), before.right, right, len(words), false.another, profile_false)


def _said(clip: SpokenClip) -> EnrolledSpeech:
    return EnrolledSpeech(clip.text, read_sound(ROOT / clip.path))


def _figures(found: list[Person]) -> list[Figure]:
    n, words = sum(p.clips for p in found), sum(p.words for p in found)
    if not n:
        return []
    figures = [Figure("people: speakers with more than one stop", len(found), "")]
    for name in ("base", "profile"):
        missed = n - sum(getattr(p, name) for p in found)
        note = f"({missed} of {n}, at most {at_most(missed, n):.3f} with 95 %)"
        figures.append(Figure(f"people: stop missed, {name}", missed / n, "of clips", note=note))
        false = sum(getattr(p, f"{name}_false") for p in found)
        note = f"({false} of {words})"
        what = f"people: other words taken, {name}"
        figures.append(Figure(what, false / max(words, 1), "of words", note=note))
    return figures

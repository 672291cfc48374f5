# SPDX-License-Identifier: BSD-3-Clause
"""Whether figures from before the noise floor fell fast still hold: is the same sound looked at?

Since then the floor of the noise reduction falls at once where noise ends, and the speech detector
begins anew after deafening sound; both decide what is looked at, and nothing else of what is heard
has changed. So where the detector is on the same side of its threshold in every frame, the figures
of `trials` and `armed` are what they would be today. One scene in EVERY (10) of both is looked at.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from unittest.mock import patch

import numpy as np
from numpy.typing import NDArray

from bench import voice_armed, voice_trials
from bench.figures import Figure
from bench.voice_clips import Trial, chunks, trials_of
from bench.voice_stream import whole_frames
from voice_assist import denoise
from voice_assist.assembly import limit_torch
from voice_assist.audio.source import Framer
from voice_assist.config import load_voice_config
from voice_assist.types import Samples
from voice_assist.vad.deafened import Deafened
from voice_assist.vad.detector import Detector, make_detector

EVERY = int(os.environ.get("EVERY", "10"))


def measure() -> list[Figure]:
    """Of each set: scenes in which one frame changed sides, frames, the largest difference."""
    config = load_voice_config()
    limit_torch(config)
    detector = make_detector(config.audio.vad)
    sets = {f"trials, {name}": some for name, some in voice_trials.conditions(3).items()}
    sets["human speech, armed"] = trials_of(voice_armed.clips())
    return [figure for name, trials in sets.items() for figure in _of(name, trials, detector)]


def _of(name: str, trials: list[Trial], detector: Detector) -> Iterator[Figure]:
    vad = load_voice_config().audio.vad
    scenes = changed = frames = restarts = 0
    furthest = 0.0
    for chunk in chunks(trials[::EVERY]):
        for _, scene in chunk.scenes():
            with patch.object(denoise, "_DROP_FALL", denoise._NOISE_FALL):
                before, _ = _probabilities(scene.sound, detector)
            now, begun = _probabilities(scene.sound, detector)
            scenes, changed = (
                scenes + 1,
                changed
                + any(((before >= at) != (now >= at)).any() for at in (vad.start, vad.stop)),
            )
            frames, restarts = frames + len(now), restarts + begun
            furthest = max(furthest, float(np.abs(before - now).max(initial=0.0)))
    if not scenes:
        return
    note = f"({scenes} scenes, {frames} frames; the detector began anew {restarts} times)"
    yield Figure(f"{name}: scenes heard otherwise", changed, "", 0.0, note=note)
    yield Figure(f"{name}: probability of speech, largest difference", furthest, "")


def _probabilities(sound: Samples, detector: Detector) -> tuple[NDArray[np.float64], int]:
    """Of speech, of each frame; and how often the detector would begin anew."""
    clean = denoise.Denoiser(load_voice_config().audio.denoise)
    deafened, restarts, found = Deafened(), 0, []
    detector.reset()
    for frame in Framer().push(whole_frames(sound), 0.0):
        restarts += deafened.is_over(frame)
        found.append(detector(clean(frame.samples)))
    return np.array(found), restarts

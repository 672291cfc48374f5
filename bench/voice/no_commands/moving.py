# SPDX-License-Identifier: BSD-3-Clause
"""The same human speech as armed, while the robot moves: a "stop" inside a sentence is one, too.

Nobody wrote the talk down. So another recogniser, Whisper base, says in which of the clips that
stopped the robot the word was said. Such a stop is right, but stays among the false ones.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

from bench.common import resumable
from bench.voice.hearing import pieces
from bench.voice.hearing.pieces import SceneRecord
from bench.voice.material.mixing import chunks, trials_of
from bench.voice.no_commands.armed import by_kind, clips, fired
from bench.voice.outcomes import hours
from support.figures import ROOT, Figure
from voice_assist.audio.sound_file import read_sound
from voice_assist.recognizer.checkpoint import MULTILINGUAL, multilingual_path
from voice_assist.recognizer.precision import FLOAT32
from voice_assist.recognizer.whisper import ENGLISH, load_multilingual
from voice_assist.text.normalize import normalize

MOST = 6.0  # [1/h] false stops in motion


def measure() -> list[Figure]:
    """Motions, of which there shall be none, and stops per hour; by kind of clip."""
    trials = [replace(trial, is_moving=True) for trial in trials_of(clips())]
    records = pieces.measured("moving", {"": chunks(trials)})[""]
    figures = by_kind("moving", records, MOST)
    if figures:
        stopped = [r for r in records if "stop" in r.heard.taken]
        figures += _said(stopped)
        data = {"fired": fired(stopped)}
        resumable.write_details("voice/moving_fired.json", hours(records), data)
    return figures


def _said(stopped: Sequence[SceneRecord]) -> Iterable[Figure]:
    """How many of those clips hold the word by what Whisper base writes; it may be wrong, too."""
    if not multilingual_path().is_file():
        print("no Whisper base (make languages): it is left out in which clips somebody says stop")
        return
    judge = load_multilingual(MULTILINGUAL, "cpu", ENGLISH, FLOAT32).model
    sounds = (read_sound(ROOT / record.label["path"]) for record in stopped)
    texts = (judge.transcribe(sound, language=ENGLISH, fp16=False)["text"] for sound in sounds)
    count = sum("stop" in normalize(text) for text in texts)
    name = "human speech, moving: clips with a stop in which Whisper base writes the word"
    yield Figure(name, count, "", note=f"of {len(stopped)} clips")

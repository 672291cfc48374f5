# SPDX-License-Identifier: BSD-3-Clause
"""Whisper models of each size in the node's pipeline, beside `whisper.transcribe`; CPU time.

The weights are random, of the true shape; only the embedded model is real. Random text is soon
hopeless, as is most talk. A process of its own measures each model, so that no memory is shared.
Which weights a real model needs is not asked: WEIGHTS=file measures that file beside them.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from resource import RUSAGE_SELF, getrusage
from tempfile import TemporaryDirectory

import numpy as np
import torch
from whisper.model import ModelDimensions, Whisper

from bench.voice.hearing.replay_stream import SceneListener, SoundScene
from support.figures import ROOT, Figure
from support.theatre_sound import speak
from voice_assist.recognizer.whisper import OpenAIRecognizer, load_recognizer
from voice_assist.types import RATE, Mode, Samples

SIZES = {"embedded": (0, 0), "tiny": (384, 4), "base": (512, 6), "small": (768, 12)}
MOST_REALTIME = 0.5  # factor, of base; aim of the project
TALK = (
    "we could send the report to the ward this afternoon",
    "the next patient has been waiting since eight",
    "can you turn the light a little to the left",
    "that is about what we saw last week",
)
ROUNDS = 5


def measure() -> list[Figure]:
    """Time, real-time factor and memory of each size."""
    figures = []
    with TemporaryDirectory() as folder:
        for name, (width, layers) in SIZES.items():
            model = name if not width else _random(Path(folder) / f"{name}.pt", width, layers)
            figures += _of(name, model)
        if own := os.environ.get("WEIGHTS"):
            figures += _of(f"{Path(own).stem}, real weights", own)
    return figures


def _of(name: str, model: str) -> list[Figure]:
    command = [sys.executable, "-m", "bench.voice.sizes", model]
    done = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True)
    found = json.loads(done.stdout.splitlines()[-1])
    limit = MOST_REALTIME if name.startswith("base") else None
    figures = [
        Figure(f"{name}: 2 s to text", 1e3 * found["text"], "ms", note=f"({found['dtype']})"),
        Figure(f"{name}: scores of the commands", 1e3 * found["scores"], "ms"),
        Figure(f"{name}: real-time factor on talk", found["realtime"], "", limit),
        Figure(f"{name}: memory", found["rss"] / 1e6, "MB"),
    ]
    if "theirs" in found:
        label = f"{name}: `whisper.transcribe` of the same"
        figures.append(Figure(label, 1e3 * found["theirs"], "ms"))
    return figures


def _random(path: Path, width: int, layers: int) -> str:
    dims = ModelDimensions(
        80, 1500, width, width // 64, layers, 51865, 448, width, width // 64, layers
    )
    torch.manual_seed(0)
    state = {n: w.half() for n, w in Whisper(dims).state_dict().items()}
    torch.save({"dims": vars(dims), "model_state_dict": state}, path)
    return str(path)


def main(model: str) -> None:
    """Print the figures of one model."""
    torch.set_num_threads(1)
    recognizer = load_recognizer(model)
    sound = np.zeros(2 * RATE, np.float32)
    word = speak("pull more", "en-us", 150)
    sound[RATE // 2 :][: len(word)] = word[: RATE + RATE // 2]
    found: dict[str, float | str] = {}
    found["text"] = _quickest(lambda: recognizer.transcribe(sound.copy()))
    fixed = sound.copy()
    fixed.flags.writeable = False
    recognizer.transcribe(fixed)
    phrases = ("hey robot", "tense", "release", "pull more", "pull less", "stop", "terminate")
    found["scores"] = _quickest(lambda: recognizer.score(fixed, phrases))
    listener = SceneListener(model)
    heard = listener(SoundScene(_talk(), Mode.ACTIVE))
    found["realtime"] = heard.compute / heard.streamed
    found["rss"] = 1024 * getrusage(RUSAGE_SELF).ru_maxrss  # before the other way needs its own
    found["dtype"] = "float32"
    if isinstance(recognizer, OpenAIRecognizer):
        found["dtype"] = str(recognizer.dtype).removeprefix("torch.")
        whole = recognizer.model.float()
        given = {"language": "en", "fp16": False, "temperature": 0.0}  # once, not up to six times
        found["theirs"] = _quickest(lambda: whole.transcribe(sound, **given), 1)
    print(json.dumps(found))


def _quickest(work: Callable[[], object], rounds: int = ROUNDS) -> float:
    """Least CPU time of some rounds [s]."""
    times = []
    for _ in range(rounds + 1):
        begun = time.process_time()
        work()
        times.append(time.process_time() - begun)
    return min(times[1:])


def _talk() -> Samples:
    """Talk with short pauses, shape (n,)."""
    quiet = np.zeros(RATE // 2, np.float32)
    parts = [part for text in TALK * 2 for part in (quiet, speak(text, "en-us", 150))]
    noise = 1e-3 * np.random.default_rng(0).standard_normal(sum(map(len, parts)))
    talk: Samples = (np.concatenate(parts) + noise).astype(np.float32)
    return talk


if __name__ == "__main__":
    main(sys.argv[1])

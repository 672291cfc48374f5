# SPDX-License-Identifier: BSD-3-Clause
"""Share of a core and memory of the voice pipeline while nobody speaks; in a process of its own."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

from bench.voice.material.theatre_noise import make
from support.figures import ROOT, Figure
from voice_assist.assembly import make_pipeline
from voice_assist.audio.source import Framer
from voice_assist.config import load_voice_config

SECONDS = 60.0  # of each sound
KINDS = ("silence", "theatre")


def measure() -> list[Figure]:
    """Run this module as a program, so that no other part's memory counts."""
    command = [sys.executable, "-m", "bench.voice.idle"]
    done = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True)
    found = json.loads(done.stdout.splitlines()[-1])
    figures = [
        Figure(f"idle in {kind}", 100 * found[kind], "% of a core", 50.0, note="(pipeline alone)")
        for kind in KINDS
    ]
    note = "(pipeline and networks, without rospy)"
    return [*figures, Figure("memory", found["rss"] / 1e6, "MB", 600.0, note=note)]


def main() -> None:
    """Stream each sound as fast as it goes, and print the CPU time per second of sound."""
    pipeline = make_pipeline(load_voice_config(), time.monotonic)
    pipeline.warm_up((0.1 * np.random.default_rng(0).standard_normal(32_000)).astype(np.float32))
    found = {}
    for kind in KINDS:
        sound = make(kind, SECONDS, 0)
        pipeline.reset()
        begin = time.process_time()
        for frame in Framer().push(sound, 0.0):
            pipeline(frame)
        found[kind] = (time.process_time() - begin) / SECONDS
    print(json.dumps({**found, "rss": resident()}))


def resident() -> int:
    """Most memory of this process that was resident [bytes]."""
    for line in Path("/proc/self/status").read_text(encoding="utf-8").splitlines():
        if line.startswith("VmHWM:"):
            return int(line.split()[1]) * 1024
    raise RuntimeError("/proc/self/status has no VmHWM; it needs Linux")


if __name__ == "__main__":
    main()

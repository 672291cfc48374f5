#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Prints what a sound file would command in active mode, and why not, where it would not.

It needs no ROS master:
. catkin_ws/devel/setup.sh; .venv/bin/python examples/what_would_be_commanded.py sound.wav
"""

import sys

import numpy as np

import voice_assist as va

QUIET = np.zeros(16_000, np.float32)  # 1 s before and after, so that the end can be heard


def main(path: str) -> None:
    """Stream a file through the pipeline of the voice node."""
    now = 0.0  # [s] of the stream
    pipeline = va.make_pipeline(va.load_voice_config(), lambda: now)
    pipeline.set_mode(va.Mode.ACTIVE, "example")
    for frame in va.Framer().push(np.concatenate([QUIET, va.read_sound(path), QUIET]), 0.0):
        now = frame.stamp + frame.duration
        for event in pipeline(frame):
            if isinstance(event, va.UtteranceDecision):
                text, rejection = event.hypothesis.text, event.rejection
                if rejection is None:
                    print(f"{text!r}: {event.command!r}, confidence {event.confidence:.2f}")
                else:
                    print(f"{text!r}: nothing, {rejection.reason.value}: {rejection.words}")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("what_would_be_commanded.py needs a sound file")
    try:
        main(sys.argv[1])
    except va.VoiceError as error:
        sys.exit(str(error))

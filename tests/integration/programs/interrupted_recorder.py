# SPDX-License-Identifier: BSD-3-Clause
"""The recorder node, interrupted in the midst of looking at its own state."""

import os
import signal
import sys
from pathlib import Path

from session_log.recording.recorder import Recorder
from session_log.ros.recorder_node import main

DONE = "was_interrupted"  # file in the folder that is the only argument

_loss = Recorder._loss  # called while the recorder's lock is held


def interrupt_once(recorder):
    Recorder._loss = _loss
    (FOLDER / DONE).touch()
    os.kill(os.getpid(), signal.SIGINT)
    return _loss(recorder)


if __name__ == "__main__":
    FOLDER = Path(sys.argv.pop())  # the node itself takes no word
    Recorder._loss = interrupt_once
    main()

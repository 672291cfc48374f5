# SPDX-License-Identifier: BSD-3-Clause
"""The process that draws the scene: pictures on request, or a window that shows it live."""

from __future__ import annotations

import os
import signal
import sys
from contextlib import suppress
from multiprocessing.connection import Connection

from rst_control.simulation.rendering.state import SceneSetup
from typed_config.priority import set_priority

NICE = 15  # of drawing: what moves the robot goes first


def serve(pipe: Connection) -> None:
    """Draw what comes through the pipe until it is closed: bytes of PNG, or b"" for the window.

    An answer that is text says why nothing can be drawn.
    """
    # Loading PyBullet takes long: only now, after this process has lowered its priority.
    from rst_control.simulation.rendering.painter import ScenePainter, png_bytes

    setup: SceneSetup = pipe.recv()
    try:
        window = setup.cameras[0] if setup.window else None
        painter = ScenePainter(setup.scene, setup.urdf, window)
    except Exception as error:  # the top of the process: report to the process that started it
        pipe.send(f"the scene cannot be drawn: {error}")
        return
    pipe.send(b"")
    with painter, suppress(EOFError, BrokenPipeError, ConnectionResetError):
        while True:
            state = pipe.recv()
            if setup.window:
                painter.show(state)
                pipe.send(b"")
            else:
                pipe.send(png_bytes(painter.picture(state, setup.cameras)))


def _lower_priority() -> None:
    """Let what moves the robot go first, also where it started this process."""
    with suppress(PermissionError, AttributeError):
        os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
    set_priority(NICE)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # a closed pipe ends it, not Ctrl-C


if __name__ == "__main__":
    _lower_priority()
    serve(Connection(int(sys.argv[1])))

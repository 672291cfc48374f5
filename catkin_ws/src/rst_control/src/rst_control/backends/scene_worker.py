# SPDX-License-Identifier: BSD-3-Clause
"""A process that draws the scene: pictures on request, or a window that shows it live.

`SceneWorker` starts it and speaks to it by a pipe; drawing takes a tenth of a second and more, which the physics
must not wait for.
"""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import dataclass
from multiprocessing.connection import Connection, Pipe
from pathlib import Path

from rst_control.backends.scene_picture import ScenePainter, SceneState, png_bytes
from rst_control.config import CameraConfig, SceneConfig

START_LIMIT = 60.0  # [s] for the process to come up
PICTURE_LIMIT = 30.0  # [s] for one picture
COURTESY = 5  # steps of priority that drawing leaves to others


class SceneLost(RuntimeError):
    """The drawing process ended or does not answer."""


@dataclass(frozen=True)
class SceneSetup:
    """What the process needs to know, sent once."""

    scene: SceneConfig
    cameras: tuple[CameraConfig, ...]
    urdf: Path
    window: bool  # a window instead of pictures; needs a screen


class SceneWorker:
    """The drawing process, seen from outside; for one thread at a time.

    Raises:
        SceneLost: The process could not start; says why.
    """

    def __init__(self, setup: SceneSetup) -> None:
        if setup.window and not os.environ.get("DISPLAY"):
            raise SceneLost("no screen for the window: DISPLAY is not set; start with gui:=false")
        self._pipe, theirs = Pipe()
        self._process = subprocess.Popen(
            [sys.executable, "-m", "rst_control.backends.scene_worker", str(theirs.fileno())],
            pass_fds=[theirs.fileno()],
            env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
            stdout=subprocess.DEVNULL,
        )
        theirs.close()
        self._is_free = True
        self._pipe.send(setup)
        self._answer(START_LIMIT)

    def picture(self, state: SceneState) -> bytes:
        """PNG of the scene.

        Raises:
            SceneLost: The process ended or does not answer.
        """
        self._send(state)
        return self._answer(PICTURE_LIMIT)

    def show(self, state: SceneState) -> bool:
        """Show a state in the window, unless it is still busy with the last one.

        Returns:
            False where it was busy.

        Raises:
            SceneLost: The window was closed.
        """
        if not self._is_free:
            if not self._pipe.poll(0.0):
                if self._process.poll() is not None:
                    raise SceneLost("the window was closed")
                return False
            self._answer(PICTURE_LIMIT)
        self._send(state)
        self._is_free = False
        return True

    def close(self) -> None:
        """End the process."""
        self._pipe.close()
        try:
            self._process.wait(timeout=2.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()

    def _send(self, state: SceneState) -> None:
        try:
            self._pipe.send(state)
        except OSError as error:
            raise SceneLost("the drawing process ended") from error

    def _answer(self, limit: float) -> bytes:
        try:
            if not self._pipe.poll(limit):
                raise SceneLost(f"the drawing process gave no answer for {limit:g} s")
            answer = self._pipe.recv()
        except (EOFError, OSError) as error:
            raise SceneLost("the drawing process ended") from error
        if isinstance(answer, str):
            raise SceneLost(answer)
        self._is_free = True
        return bytes(answer)


def serve(pipe: Connection) -> None:
    """Draw what comes through the pipe until it is closed; whatever moves the robot goes first."""
    os.nice(COURTESY)
    setup: SceneSetup = pipe.recv()
    try:
        painter = ScenePainter(setup.scene, setup.urdf, window=setup.window)
    except Exception as error:  # the top of the process: report to whoever started it
        pipe.send(f"the scene cannot be drawn: {error}")
        return
    pipe.send(b"")
    with painter:
        while True:
            try:
                state = pipe.recv()
            except EOFError:
                return
            if setup.window:
                painter.show(state)
                pipe.send(b"")
            else:
                pipe.send(png_bytes(painter.picture(state, setup.cameras)))


if __name__ == "__main__":
    serve(Connection(int(sys.argv[1])))

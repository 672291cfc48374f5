# SPDX-License-Identifier: BSD-3-Clause
"""Starts the process that draws the scene, and exchanges messages with it by a pipe.

A picture takes a tenth of a second and more, which the physics must not wait for.
"""

from __future__ import annotations

import os
import subprocess
import sys
from multiprocessing.connection import Pipe

from rst_control.simulation.rendering.state import SceneSetup, SceneState
from rst_control.simulation.rendering.window import window_obstacle

START_LIMIT = 60.0  # [s] for the process to come up
PICTURE_LIMIT = 30.0  # [s] for one picture


class SceneLostError(RuntimeError):
    """The drawing process ended or does not answer."""


class SceneWorker:
    """The drawing process, seen from outside; for one thread at a time.

    The process starts while its caller goes on. On a busy machine that takes long, as it has the
    lowest priority. Once it is lost, it is ended and of no more use.

    Raises:
        SceneLostError: The window cannot open; says why.
    """

    def __init__(self, setup: SceneSetup) -> None:
        if setup.window and (obstacle := window_obstacle()):
            raise SceneLostError(obstacle)
        self._pipe, theirs = Pipe()
        self._process = subprocess.Popen(
            [sys.executable, "-m", "rst_control.simulation.rendering.server", str(theirs.fileno())],
            pass_fds=[theirs.fileno()],
            env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
            stdout=subprocess.DEVNULL,
            start_new_session=True,  # a closed pipe ends it, not Ctrl-C
        )
        theirs.close()
        self._is_free = self._is_up = False
        self._pipe.send(setup)

    def wait_until_up(self) -> None:
        """Wait until the process can draw.

        Raises:
            SceneLostError: It could not start; says why.
        """
        if not self._is_up:
            self._answer(START_LIMIT)
            self._is_up = True

    def picture(self, state: SceneState) -> bytes:
        """PNG of the scene.

        Raises:
            SceneLostError: The process ended or does not answer.
        """
        self.wait_until_up()
        self._send(state)
        return self._answer(PICTURE_LIMIT)

    def show(self, state: SceneState) -> bool:
        """Show a state in the window, unless it is still busy with the last one.

        Returns:
            False where it was busy.

        Raises:
            SceneLostError: The window was closed.
        """
        if not self._is_free:
            if not self._pipe.poll(0.0):
                if self._process.poll() is not None:
                    raise self._lost("the window was closed")
                return False
            self._answer(PICTURE_LIMIT)
        self._send(state)
        self._is_free = False
        return True

    def close(self) -> None:
        """End the process, which keeps nothing; calling it twice does no harm."""
        self._pipe.close()
        self._process.kill()
        self._process.wait()

    def _send(self, state: SceneState) -> None:
        try:
            self._pipe.send(state)
        except OSError as error:
            raise self._lost("the drawing process ended") from error

    def _answer(self, limit: float) -> bytes:
        try:
            if not self._pipe.poll(limit):
                raise self._lost(f"the drawing process gave no answer for {limit:g} s")
            answer = self._pipe.recv()
        except (EOFError, OSError) as error:
            raise self._lost("the drawing process ended") from error
        if isinstance(answer, str):
            raise self._lost(answer)
        self._is_free = True
        return bytes(answer)

    def _lost(self, words: str) -> SceneLostError:
        """End a process that cannot be used any more; returns what to raise."""
        self.close()
        return SceneLostError(words)

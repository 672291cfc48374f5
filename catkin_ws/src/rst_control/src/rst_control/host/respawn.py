# SPDX-License-Identifier: BSD-3-Clause
"""Runs a command and starts it again: `respawn [--always] COMMAND ARGUMENTS`, before a node.

roslaunch can start a node again, but after a wrong setting it would do so for ever. This program
knows a crash by the status: a signal, or 1. A wrong setting ends a node with status 2, after it has
said why, and a node that was asked to end has status 0. Both of these end the launch, and so does a
node that crashes again and again.

With `--always`, for a node that moves nothing, only a wrong setting at the first start ends the
launch. Later the system is at work, and goes on without the node while that is started again.

Neither outlives its parent. Where roslaunch is killed, so that nobody is left to end its
nodes, the node is asked to end, and killed where it does not; and where this is killed, so is it.
"""

from __future__ import annotations

import ctypes
import os
import signal
import subprocess
import sys
import time
from collections import deque
from collections.abc import Sequence
from types import FrameType
from typing import Final

WRONG: Final = 2  # status of what cannot be started as it was asked for
CRASHED: Final = 1  # status of Python after an exception that nobody caught
PAUSE: Final = 1.0  # [s] before the next start
MOST: Final = 5  # crashes within SPAN after which it is given up
SPAN: Final = 120.0  # [s]
PARENT_PERIOD: Final = 0.5  # [s] between two checks that the parent is still there
PATIENCE: Final = 10.0  # [s] for a node to end by itself once that one is gone
_PR_SET_PDEATHSIG: Final = 1
RESTART: Final = "RESPAWN_RESTART"  # variable that says to the command that it had crashed


class Respawner:
    """Runs one command, again where it crashes.

    Args:
        command: With its arguments.
        is_always: It is started again however it ended, but for a wrong setting at first.
    """

    def __init__(self, command: Sequence[str], is_always: bool = False) -> None:
        self._command, self._is_always = tuple(command), is_always
        self._child: subprocess.Popen[bytes] | None = None
        self._crashes: deque[float] = deque(maxlen=MOST)  # [s] when, steady clock
        self._is_asked_to_end = False
        self._parent = os.getppid()

    def run(self) -> int:
        """Run it until it is not to be started again; gives its status."""
        variables = dict(os.environ)
        while True:
            is_first = RESTART not in variables
            try:
                self._child = subprocess.Popen(
                    self._command, preexec_fn=_die_with_parent, env=variables
                )
            except OSError as error:
                _say(f"{self._command[0]} cannot be started: {error.strerror}")
                return WRONG
            variables[RESTART] = "1"
            if self._is_asked_to_end:
                self._child.send_signal(signal.SIGINT)
            status = self._wait(self._child)
            if self._is_asked_to_end or not self._may_start_again(status, is_first):
                return status if status >= 0 else 128 - status
            _say(f"{self._command[0]} {ending(status)}; it is started anew")
            time.sleep(PAUSE)
            if self._is_asked_to_end:
                return 0

    def end(self, number: int, _: FrameType | None) -> None:
        """Pass a signal on, and start nothing again; a handler of signals."""
        self._is_asked_to_end = True
        if self._child is not None and self._child.poll() is None:
            self._child.send_signal(number)

    def _wait(self, child: subprocess.Popen[bytes]) -> int:
        """Its status; ends it once the parent is gone."""
        while os.getppid() == self._parent:
            try:
                return child.wait(PARENT_PERIOD)
            except subprocess.TimeoutExpired:
                continue
        if not self._is_asked_to_end:
            _say(f"the process that started this is gone; {self._command[0]} is asked to end")
            self.end(signal.SIGINT, None)
        try:
            return child.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            child.kill()
            return child.wait()

    def _may_start_again(self, status: int, is_first: bool) -> bool:
        if self._is_always:
            return not (is_first and status == WRONG)
        return is_crash(status) and self._is_rare()

    def _is_rare(self) -> bool:
        """Whether it may crash once more; counts the crashes."""
        now = time.monotonic()
        self._crashes.append(now)
        if len(self._crashes) < MOST or now - self._crashes[0] > SPAN:
            return True
        _say(f"{self._command[0]} ended {MOST} times within {SPAN:g} s; it is given up")
        return False


def is_crash(status: int) -> bool:
    """Whether a status, as `subprocess` gives it, means a crash."""
    return status == CRASHED or status < 0


def ending(status: int) -> str:
    """How a process ended, in words."""
    if status >= 0:
        return f"ended with status {status}"
    return f"was ended by {signal.Signals(-status).name}"


def _die_with_parent() -> None:
    """In the child: killing the respawner ends its child too."""
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL, 0, 0, 0)


def _say(words: str) -> None:
    print(f"[respawn] {words}", file=sys.stderr, flush=True)


def main() -> None:
    """Run the command of the arguments.

    Raises:
        SystemExit: It has ended.
    """
    is_always = sys.argv[1:2] == ["--always"]
    command = sys.argv[1 + is_always :]
    if not command:
        _say("usage: respawn [--always] COMMAND [ARGUMENT...]")
        sys.exit(WRONG)
    respawner = Respawner(command, is_always)
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, respawner.end)
    sys.exit(respawner.run())

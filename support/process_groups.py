# SPDX-License-Identifier: BSD-3-Clause
"""Programs in groups of their own, which a program starts and ends in order.

Ctrl-C at the terminal reaches the program alone that started them. Where that one is killed, so
that nobody is left to end them, the kernel asks them to end.
"""

from __future__ import annotations

import ctypes
import os
import signal
import subprocess
import threading
from collections.abc import Sequence
from typing import Any, Final

from support.interrupt import undisturbed

STOP_TIME: Final = 60.0  # [s] for roslaunch, which gives each node up to 17 s, to end
_PR_SET_PDEATHSIG: Final = 1
_LIBC: Final = ctypes.CDLL(None)


def start_group(command: Sequence[str], **options: Any) -> subprocess.Popen[bytes]:
    """Start a program in a group of its own; `options` are those of `subprocess.Popen`.

    The kernel takes the end of the thread that starts it for the end of the whole program. So only
    what the main thread starts is asked to end where this program is killed.
    """
    is_main = threading.current_thread() is threading.main_thread()
    ready = _end_with_parent if is_main else _heed
    return subprocess.Popen(command, start_new_session=True, preexec_fn=ready, **options)


def end_group(process: subprocess.Popen[bytes], patience: float = STOP_TIME) -> None:
    """Ask a process group to end; after a time [s], make it. Ctrl-C does not cut this short."""
    if process.poll() is not None:
        return
    with undisturbed():
        process.send_signal(signal.SIGINT)
        try:
            process.wait(patience)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()


def _heed() -> None:
    """In the child: heed the request, which a shell has ignored in what runs in its background."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def _end_with_parent() -> None:
    """In the child: whoever started it is gone."""
    _heed()
    _LIBC.prctl(_PR_SET_PDEATHSIG, signal.SIGINT, 0, 0, 0)

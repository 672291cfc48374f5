# SPDX-License-Identifier: BSD-3-Clause
"""What keeps a window from opening, found before it is tried: pybullet then ends its process."""

from __future__ import annotations

import ctypes
import os

_LIBRARIES = {"libGL.so.1": "libgl1", "libX11.so.6": "libx11-6"}  # with their packages of Debian
_WITHOUT = "start without the window (gui:=false; make demo without GUI=1)"


def window_obstacle() -> str:
    """Why the simulator's window cannot open, and what to do; empty: nothing is known."""
    display = os.environ.get("DISPLAY")
    if not display:
        return f"no screen for the window: DISPLAY is not set; {_WITHOUT}"
    missing = [name for name in _LIBRARIES if not _is_installed(name)]
    if missing:
        packages = " ".join(_LIBRARIES[name] for name in missing)
        install = f"apt-get install --no-install-recommends {packages}"
        return f"the window needs {' and '.join(missing)}: {install}, or {_WITHOUT}"
    if not _opens(display):
        return f"no screen for the window: nothing answers at DISPLAY={display}; {_WITHOUT}"
    return ""


def _is_installed(library: str) -> bool:
    try:
        ctypes.CDLL(library)
    except OSError:
        return False
    return True


def _opens(display: str) -> bool:
    x11 = ctypes.CDLL("libX11.so.6")
    x11.XOpenDisplay.restype = ctypes.c_void_p
    screen = x11.XOpenDisplay(display.encode())
    if not screen:
        return False
    x11.XCloseDisplay(ctypes.c_void_p(screen))
    return True

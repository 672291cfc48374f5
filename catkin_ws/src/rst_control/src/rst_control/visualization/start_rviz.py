# SPDX-License-Identifier: BSD-3-Clause
"""Starts rviz on the scene, or says how to get it: it is no part of what `make setup` installs."""

from __future__ import annotations

import os
import shutil
import sys

from rst_control.config import PACKAGE

LAYOUT = PACKAGE / "urdf" / "rviz" / "session.rviz"
MISSING = "rviz is not installed, so nothing is shown; the rest runs on (apt-get install rviz)"


def main() -> None:
    """Become rviz with our layout; arguments, such as those of roslaunch, go through to it."""
    program = shutil.which("rviz")
    if program is None:
        sys.exit(MISSING)
    os.execv(program, [program, "-d", str(LAYOUT), *sys.argv[1:]])

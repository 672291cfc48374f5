# SPDX-License-Identifier: BSD-3-Clause
"""Sources of a PulseAudio server, which PortAudio shows only as one device."""

from __future__ import annotations

import shutil
import subprocess

PREFIX = "pulse:"  # of a microphone's name: pulse:<source>


def pulse_sources() -> tuple[str, ...]:
    """Names of the sources; empty where no server answers or `pactl` is missing."""
    program = shutil.which("pactl")
    if program is None:
        return ()
    try:
        listing = subprocess.run(
            [program, "list", "short", "sources"], capture_output=True, text=True, timeout=2.0
        )
    except subprocess.TimeoutExpired:
        return ()
    rows = (line.split("\t") for line in listing.stdout.splitlines())
    return tuple(row[1] for row in rows if len(row) > 1)

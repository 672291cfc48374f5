#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Reads a recorded session into columns, and into data frames where pandas is installed.

Start it like plan_through_trocar.py, with the folder of a session behind it.
"""

from __future__ import annotations

import sys

from session_log import SessionReader, read_columns, read_summary

UTTERANCES, STATES = "/voice_assist/utterance", "/rst_control/state"


def main(session: str) -> None:
    """Show what was heard, and the largest RCM error inside the patient."""
    reader = SessionReader(session)
    recording = read_summary(reader)
    print(f"{recording.messages} messages in {recording.duration:.1f} s")
    heard, states = (read_columns(reader, topic) for topic in (UTTERANCES, STATES))
    taken = heard["command"] != ""
    for transcript, command in zip(
        heard["transcript"][taken], heard["command"][taken], strict=True
    ):
        print(f"{transcript!r} was taken for {command!r}")
    inside = states["insertion"] >= 0.0
    print(f"RCM error inside the patient: {states['rcm_error'][inside].max() * 1e6:.1f} um at most")
    try:
        import pandas as pd
    except ImportError:
        print("pandas is not installed; the columns above are NumPy arrays")
    else:
        frame = pd.DataFrame(states).set_index("log_time")
        print(frame.groupby("state")[["tension", "path_speed"]].max())


if __name__ == "__main__":
    main(sys.argv[1])

#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Reads a recorded session into columns, and into data frames where pandas is installed.

Start it like plan_through_trocar.py, with the folder of a session behind it.
"""

import sys

from session_log import SessionLogError, SessionReader, read_columns, read_summary


def main(session: str = ".") -> None:
    """Show what was heard, and the largest RCM error inside the patient."""
    reader = SessionReader(session)
    recording = read_summary(reader)
    print(f"{recording.messages} messages in {recording.duration:.1f} s")
    heard = read_columns(reader, "/voice_assist/utterance")
    states = read_columns(reader, "/rst_control/state")
    if not heard or not states:
        sys.exit(f"{session}: no utterance or no state was recorded")
    for transcript, command in zip(heard["transcript"], heard["command"], strict=True):
        if command:
            print(f"{transcript!r} was taken for {command!r}")
    inside = states["rcm_error"][states["insertion"] >= 0.0]
    print(f"RCM error inside the patient: {inside.max(initial=0.0) * 1e6:.1f} um at most")
    try:
        import pandas as pd
    except ImportError:
        print("pandas is not installed; the columns above are NumPy arrays")
    else:
        frame = pd.DataFrame(states).set_index("log_time")
        print(frame.groupby("state")[["tension", "path_speed"]].max())


if __name__ == "__main__":
    try:
        main(*sys.argv[1:2])
    except SessionLogError as error:
        sys.exit(str(error))

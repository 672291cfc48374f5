# SPDX-License-Identifier: BSD-3-Clause
"""Options of `session_log replay`; apart from the rest, so that other commands need not load it."""

from __future__ import annotations

import argparse
from pathlib import Path

REPLAY_CONFIG = Path(__file__).resolve().parents[2] / "config" / "replay.yaml"


def add_replay_options(parser: argparse.ArgumentParser) -> None:
    """Declare the options beside the session."""
    parser.add_argument("--model", help="recogniser to hear with; default: the recorded one")
    parser.add_argument("--json", type=Path, help="file to write all differences to")
    help_ = "settings of the replay: who hears, and what counts as the same"
    parser.add_argument("--config", type=Path, default=REPLAY_CONFIG, help=help_)

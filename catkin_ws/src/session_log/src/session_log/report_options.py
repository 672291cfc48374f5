# SPDX-License-Identifier: BSD-3-Clause
"""Options of `session_log report`, apart from the report itself, which loads slowly."""

from __future__ import annotations

import argparse
from pathlib import Path


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add what the subcommand takes beside its settings file."""
    parser.add_argument(
        "sessions",
        type=Path,
        nargs="+",
        metavar="SESSION|FOLDER",
        help="an MCAP file, the folder of a session, or a folder with sessions below it",
    )
    parser.add_argument("--out", type=Path, metavar="DIR", help="folder; default: what was named")
    parser.add_argument("--latex", action="store_true", help="also the tables, with booktabs")
    parser.add_argument(
        "--no-pages", action="store_true", help="of a folder: no page for each session of it"
    )
    parser.add_argument(
        "--jobs", type=int, default=1, metavar="N", help="of a folder: processes (needs dask)"
    )
    parser.add_argument(
        "--cluster", default="", metavar="ADDRESS", help="of a folder: dask scheduler, host:port"
    )

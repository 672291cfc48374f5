# SPDX-License-Identifier: BSD-3-Clause
"""Options of the verbs `enroll` and `profiles`; loads nothing that takes time."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any


def add_enroll(verbs: Any) -> argparse.ArgumentParser:
    """Declare `enroll`."""
    parser: argparse.ArgumentParser = verbs.add_parser("enroll", help="learn a person's voice")
    parser.add_argument("name", help="of the person; a to z, 0 to 9, - and _")
    source = parser.add_mutually_exclusive_group()
    source.add_argument("--from-wavs", type=Path, metavar="FOLDER", help="recordings that exist")
    source.add_argument("--from-session", type=Path, metavar="SESSION", help="a session's MCAP")
    source.add_argument("--again", action="store_true", help="learn anew from the takes it has")
    words = "CSV of what was said in the session; written for filling in where it does not exist"
    parser.add_argument("--corrections", type=Path, metavar="CSV", help=words)
    parser.add_argument("--device", help="part of a microphone's name; see: voice_assist devices")
    parser.add_argument("--model", help="embedded, or a file of make train")
    parser.add_argument("--profiles", type=Path, metavar="FOLDER", help="of all profiles")
    return parser


def add_profiles(verbs: Any) -> argparse.ArgumentParser:
    """Declare `profiles`."""
    parser: argparse.ArgumentParser = verbs.add_parser("profiles", help="list, show, delete")
    parser.add_argument("action", nargs="?", choices=("list", "show", "delete"), default="list")
    parser.add_argument("name", nargs="?", help="of the profile")
    parser.add_argument("--yes", action="store_true", help="delete without a question")
    parser.add_argument("--profiles", type=Path, metavar="FOLDER", help="of all profiles")
    return parser

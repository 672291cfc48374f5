# SPDX-License-Identifier: BSD-3-Clause
"""The few figures that the README shows, the missed ones among them."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class ReadmeRow:
    """One figure in the README, under words of its own."""

    words: str
    part: str
    figure: str


ROWS = (
    ReadmeRow(
        "RCM error, planned, 1,000 random paths, max",
        "motion",
        "planned RCM error max, all samples",
    ),
    ReadmeRow(
        'a spoken "stop" in motion, end of the word to rest, p95',
        "safety.spoken",
        '"stop", human: end of the word to arm and jaws at rest p95',
    ),
    ReadmeRow(
        '"stop" said alone, at rest: right', "voice.stop", "stop, human, quiet, both ways: right"
    ),
    ReadmeRow(
        '"stop" as loud as another person\'s talk, in motion: heard',
        "voice.overlap",
        'human "stop" 0 dB over talk, moving, both ways: stopped',
    ),
    ReadmeRow(
        'false "stop" in talk, single words and other wake words, in motion',
        "voice.moving",
        "human speech, moving: false stops",
    ),
    ReadmeRow(
        'false "stop" in talk, single words and other wake words, at rest',
        "voice.armed",
        "human speech, armed: false stops",
    ),
    ReadmeRow("motion commands right, quiet", "voice.trials", "motion commands, quiet: right"),
    ReadmeRow(
        "highest tension, 10,000 failing sensors, those that scale with `gain: unchecked`",
        "site.tension",
        "tension, any fault of its sensor: peak",
    ),
)

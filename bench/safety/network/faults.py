# SPDX-License-Identifier: BSD-3-Clause
"""The ways in which a network is made bad."""

from __future__ import annotations

from dataclasses import dataclass

from bench.safety.network.relay import LinkConditions, RelayLink

CUT, WELL = LinkConditions(loss=1.0), LinkConditions()
LATE, LOSSY = LinkConditions(delay=0.5), LinkConditions(loss=0.2)


@dataclass(frozen=True)
class Fault:
    """One way in which a network is bad."""

    name: str
    link: RelayLink
    since: str  # from which the time allowed counts, see NetworkTrial
    is_before: bool = False  # it is there before the command is said
    moves_host: bool = False  # the voice's host gets another address


FAULTS = (
    Fault("link cut", RelayLink(CUT, CUT), "fault"),
    Fault("500 ms delay that begins in motion", RelayLink(LATE, LATE), "fault"),
    Fault("500 ms delay from before", RelayLink(LATE, LATE), "stop said", is_before=True),
    Fault("20 % loss, stop said", RelayLink(LOSSY, LOSSY), "stop said"),
    Fault("nothing from voice to robot", RelayLink(CUT, WELL), "fault"),
    Fault("nothing from robot to voice, stop said", RelayLink(WELL, CUT), "stop said"),
    Fault("another address", RelayLink(), "fault", moves_host=True),
    Fault("command said while cut", RelayLink(CUT, CUT), "command said", is_before=True),
)

# SPDX-License-Identifier: BSD-3-Clause
"""Bad sound moves nothing and breaks nothing, and a stop after it is heard."""

import numpy as np
import pytest

from bench.safety.sound import suite
from bench.safety.sound.kinds import DEAF, KINDS, frames
from voice_assist.audio.source import Framer
from voice_assist.types import RATE


@pytest.fixture(scope="module")
def garbage():
    return suite.Garbage()


@pytest.mark.parametrize("kind", KINDS)
def test_it_moves_nothing_and_a_stop_after_it_is_heard(garbage, kind, monkeypatch):
    monkeypatch.setattr(suite, "PIECE", 2.5)
    tally = garbage.tally = suite.SoundTally()
    garbage.hear(kind, 1)
    assert garbage.moved == 0, tally.taken
    assert tally.stops == [(kind, True)]
    assert tally.named[kind] == (kind in DEAF)


def test_lost_sound_is_a_gap_in_the_frames():
    blocks = iter([(np.zeros(RATE), 0), (np.zeros(RATE), 1000)])
    found = list(frames(Framer(), blocks, 0.0))
    jumps = np.diff([f.first_sample for f in found])
    assert set(jumps) == {512, jumps.max()} and jumps.max() > 1000

# SPDX-License-Identifier: BSD-3-Clause
import numpy as np
import pytest

from support.theatre_sound import LEVEL, RATE, levelled


def test_speech_is_brought_to_one_level():
    tone = np.sin(440.0 * 2.0 * np.pi * np.arange(RATE) / RATE)
    for amplitude in (0.2, 0.9):
        sound = levelled((amplitude * tone).astype(np.float32))
        assert np.sqrt(np.mean(sound**2)) == pytest.approx(LEVEL, rel=0.1)


def test_silence_stays_silent():
    assert not levelled(np.zeros(RATE, np.float32)).any()

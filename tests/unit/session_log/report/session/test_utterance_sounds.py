# SPDX-License-Identifier: BSD-3-Clause
"""The sound of each utterance, cut out while it passes."""

import io

import numpy as np
import pytest
import soundfile

from session_log.report.session.session_data import RecordedUtterance
from session_log.report.session.utterance_sounds import LONGEST, UtteranceSounds

BLOCK, RATE = 0.032, 16000


def utterance(start, end):
    return RecordedUtterance(start, end, end, "tense", "tense", "", "tense", 0.0, False)


def pass_by(sounds, begin, end):
    """Sound whose level says its second."""
    times = np.arange(begin, end, BLOCK)
    sounds.hear(times, [np.full(512, 1000 * int(t) % 30000, np.int16) for t in times], RATE)


def length(mp3):
    samples, rate = soundfile.read(io.BytesIO(mp3))
    return len(samples) / rate


def test_sound_is_cut_whether_it_or_its_decision_comes_first():
    sounds, before, after = UtteranceSounds(), utterance(2.0, 3.0), utterance(7.0, 8.5)
    sounds.want(after)
    pass_by(sounds, 0.0, 5.0)
    sounds.want(before)
    pass_by(sounds, 5.0, 10.0)
    found = sounds.finish()
    assert length(found[before]) == pytest.approx(1.5, abs=0.15)
    assert length(found[after]) == pytest.approx(2.0, abs=0.15)


def test_nothing_is_kept_of_what_was_not_recorded_and_little_of_what_never_ends():
    sounds, missing, long = UtteranceSounds(), utterance(100.0, 101.0), utterance(1.0, 58.0)
    sounds.want(missing)
    sounds.want(long)
    pass_by(sounds, 0.0, 60.0)
    found = sounds.finish()
    assert missing not in found and length(found[long]) < LONGEST + 0.2


def test_sound_that_nobody_asks_for_is_let_go():
    sounds = UtteranceSounds()
    for minute in range(5):
        pass_by(sounds, 60.0 * minute, 60.0 * (minute + 1))
    assert len(sounds._blocks) * BLOCK < 61.0

# SPDX-License-Identifier: BSD-3-Clause
"""A profile gets its voiceprint from its own takes, and the gate takes it from there."""

import numpy as np
import pytest

from tests.unit.voice_assist.support.records import take
from voice_assist.config import load_voice_config
from voice_assist.enrolment.voiceprint import put_voiceprint
from voice_assist.profile.profile import create_profile
from voice_assist.speaker.gate import SpeakerGate, make_gate
from voice_assist.speaker.voiceprint import FILE, VoiceprintError
from voice_assist.types import RATE, frozen_samples

CONFIG = load_voice_config(speaker__gate="on").speaker


def voiced(pitch, seconds, seed):
    """A vowel of a throat of that pitch [Hz], never twice the same."""
    rng = np.random.default_rng(seed)
    time = np.arange(round(seconds * RATE)) / RATE
    glide = pitch * (1.0 + 0.1 * np.sin(2 * np.pi * rng.uniform(1, 3) * time))
    phase = 2 * np.pi * np.cumsum(glide) / RATE
    sound = sum(np.sin(n * phase) / n for n in range(1, 20))
    return frozen_samples(0.05 * sound + 1e-3 * rng.standard_normal(len(time)))


def profile_of(folder, pitch, count=8):
    profile = create_profile("anna", "0" * 64, folder)
    for seed in range(count):
        profile.add_take(voiced(pitch, 1.0, seed), take())
    return profile


def test_a_profile_with_a_voiceprint_lets_its_own_throat_move_and_no_other(tmp_path):
    profile = profile_of(tmp_path, 110.0)
    assert not profile.has(FILE)
    known = put_voiceprint(profile, CONFIG)
    assert known.takes == 8 and known.missed <= CONFIG.max_missed
    gate = make_gate(CONFIG, profile.read(FILE))
    assert isinstance(gate, SpeakerGate)
    assert gate(voiced(110.0, 0.8, 50)) is None
    rng = np.random.default_rng(5)
    assert "not this voice" in gate(frozen_samples(0.1 * rng.standard_normal(RATE))).words


def test_a_profile_without_enough_takes_gets_none(tmp_path):
    profile = profile_of(tmp_path, 110.0, count=2)
    with pytest.raises(VoiceprintError, match="2 takes"):
        put_voiceprint(profile, CONFIG)
    assert not profile.has(FILE)

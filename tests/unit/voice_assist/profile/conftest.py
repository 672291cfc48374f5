# SPDX-License-Identifier: BSD-3-Clause
"""A profile with two takes and a file of weights."""

import numpy as np
import pytest

from tests.unit.voice_assist.support.records import take
from voice_assist.profile.profile import create_profile


@pytest.fixture
def profile(tmp_path):
    made = create_profile("ada", "ab" * 32, tmp_path / "profiles")
    sound = np.linspace(-0.5, 0.5, 16000).astype(np.float32)
    made.add_take(sound, take("tense"))
    made.add_take(sound[::-1].copy(), take("release"))
    made.put("model.pt", b"weights")
    return made

# SPDX-License-Identifier: BSD-3-Clause
"""Two processes write one profile, such as a screen that learns and a terminal that records."""

import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from tests.unit.voice_assist.support.records import take
from voice_assist.profile.manifest import ACTIVE
from voice_assist.profile.profile import VoiceProfileError, create_profile, open_profile

TAKES = 12  # of each writer


def sound(value):
    return np.full(160, value, np.float32)


def test_takes_that_came_while_another_learned_are_kept(profile):
    learner = open_profile("ada", profile.folder.parent)
    profile.add_take(sound(0.1), take("tense"))
    learner.rebase("cd" * 32)
    profile.add_take(sound(0.2), take("stop"))
    learner.put("model.pt", b"learned anew")
    learner.add_take(sound(0.3), take("release"))
    profile.add_take(sound(0.4), take("stop"))
    learner.put("settings.json", b"{}")
    learner.judge(ACTIVE)
    profile.drop("settings.json")
    found = open_profile("ada", profile.folder.parent)
    found.check()  # each sum
    kept = [(one.file, one.phrase) for one in found.manifest.takes[2:]]
    phrases = ["tense", "stop", "release", "stop"]
    assert kept == [(f"takes/{n:04d}.wav", phrase) for n, phrase in enumerate(phrases, 3)]
    levels = [float(found.sound(one)[0]) for one in found.manifest.takes[2:]]
    np.testing.assert_allclose(levels, [0.1, 0.2, 0.3, 0.4], atol=1e-4)
    assert (found.manifest.state, found.manifest.base_sha256) == (ACTIVE, "cd" * 32)
    assert found.read("model.pt") == b"learned anew"
    assert not found.has("settings.json")
    assert not (profile.folder / "settings.json").exists()
    assert found.manifest_digest == profile.manifest_digest


def test_a_file_that_another_dropped_is_not_named_again(profile):
    other = open_profile("ada", profile.folder.parent)
    other.drop("model.pt")
    profile.judge(ACTIVE)
    assert not open_profile("ada", profile.folder.parent).has("model.pt")


def test_a_profile_that_another_deleted_is_not_made_again(profile):
    other = open_profile("ada", profile.folder.parent)
    profile.folder.rename(profile.folder.parent / "elsewhere")
    with pytest.raises(VoiceProfileError, match="ada"):
        other.add_take(sound(0.1), take("stop"))
    assert not profile.folder.exists()


def test_two_writers_at_once_lose_no_take(tmp_path):
    create_profile("ada", "ab" * 32, tmp_path)
    both = threading.Barrier(2)

    def record(first):
        mine = open_profile("ada", tmp_path)
        both.wait(60.0)
        for n in range(first, first + TAKES):
            mine.add_take(sound(n / 100.0), take("stop"))

    with ThreadPoolExecutor() as pool:  # the lock is of an open folder, in one process as in two
        list(pool.map(record, (0, TAKES)))
    found = open_profile("ada", tmp_path)
    found.check()
    levels = sorted(float(found.sound(one)[0]) for one in found.manifest.takes)
    np.testing.assert_allclose(levels, np.arange(2 * TAKES) / 100.0, atol=1e-4)
    there = sorted(path.name for path in (tmp_path / "ada" / "takes").iterdir())
    assert there == [f"{n:04d}.wav" for n in range(1, 2 * TAKES + 1)]

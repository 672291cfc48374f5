# SPDX-License-Identifier: BSD-3-Clause
"""The script's clock starts with the first sound that the voice node hears."""

import re

import pytest

from demo import first_sound
from demo.first_sound import FirstSound
from support.waiting import PATIENCE

RATE = 16000
BEGAN = 100.0  # [s] when the node captured its first sample


@pytest.fixture(autouse=True)
def short(monkeypatch):
    """What is late here is late by 0.05 s."""
    monkeypatch.setattr(first_sound, "SETTLE", 1.0)


def push(sound, first_sample, samples, late=0.0):
    sound.push(BEGAN + first_sample / RATE + late, first_sample, RATE, samples)


def test_it_listens_once_a_chunk_has_come_be_it_of_silence():
    sound = FirstSound(is_file=False)
    with pytest.raises(RuntimeError, match=re.escape("no sound from the voice node within 0.1 s")):
        sound.wait_until_it_listens(0.1)
    push(sound, 0, [0] * 512)
    sound.wait_until_it_listens(0.1)


def test_the_first_that_is_no_silence_counts_and_what_came_late_does_not():
    sound = FirstSound(is_file=False)
    push(sound, 0, [0, 2, -3] * 100, late=0.08)
    push(sound, 512, [0] * 256 + [900] * 256, late=0.05)
    push(sound, 1024, [-900] * 512)
    assert sound.wait(PATIENCE) == pytest.approx(BEGAN + 768 / RATE, abs=1e-6)


def test_of_a_file_the_beginning_counts():
    sound = FirstSound(is_file=True)
    push(sound, 5120, [0] * 512)
    assert sound.wait(PATIENCE) == pytest.approx(BEGAN, abs=1e-6)


def test_silence_is_reported():
    sound = FirstSound(is_file=False)
    push(sound, 0, [0] * 512)
    with pytest.raises(RuntimeError, match=re.escape("heard nothing within 0.2 s")):
        sound.wait(0.2)

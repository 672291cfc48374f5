# SPDX-License-Identifier: BSD-3-Clause
"""Sound by its sample indices, as a WAV file with silence for what is lost."""

import wave
from array import array

import pytest

from session_log.errors import OutputFailed
from session_log.export import sound_stream
from session_log.export.sound_stream import SoundFile, StreamWatch

RATE = 16_000
MINUTE = 60 * RATE
SAMPLE = 10**9 // RATE  # [ns]
START = 1_795_200_000 * 10**9  # [ns]


@pytest.fixture
def written(tmp_path):
    """Samples of a file of blocks that begin at these indices, each of one sample of value 7.

    A block is captured when its index says, or at its time in samples.
    """

    def write(*firsts, times=None):
        path = tmp_path / "audio.wav"
        with SoundFile(path, RATE) as sound:
            for first, time in zip(firsts, times or firsts, strict=True):
                sound.add(first, array("h", [7]), START + time * SAMPLE)
        with wave.open(str(path)) as file:
            samples = array("h", file.readframes(file.getnframes()))
        assert sound.samples == len(firsts)
        return sound, samples

    return write


@pytest.mark.parametrize(
    ("firsts", "seen"),
    [
        ([0, 1, 2], [(True, 0), (False, 0), (False, 0)]),
        ([5, 9], [(True, 5), (False, 3)]),
        ([0, 100 * MINUTE], [(True, 0), (False, 100 * MINUTE - 1)]),
        ([7, 0, 3], [(True, 7), (True, 0), (False, 2)]),
        ([7, 7], [(True, 7), (True, 7)]),
    ],
)
def test_only_a_sample_below_the_next_one_begins_a_run(firsts, seen):
    watch = StreamWatch()
    assert [watch(first, 1) for first in firsts] == seen


def test_a_gap_of_minutes_is_silence_and_counted(written):
    sound, samples = written(0, 2 * MINUTE)
    assert (sound.lost, sound.unfilled) == (2 * MINUTE - 1, 0)
    assert len(samples) == 2 * MINUTE + 1 and samples[-1] == 7 and sum(samples) == 14


def test_the_time_between_two_runs_is_silence_and_counted(written):
    sound, samples = written(100, 101, 50, 51, times=(100, 101, 105, 106))
    assert (sound.lost, list(samples)) == (3, [7, 7, 0, 0, 0, 7, 7])
    assert sound.start == START + 100 * SAMPLE


@pytest.mark.parametrize("time", [102, 101, 50])
def test_a_run_that_follows_at_once_or_by_a_clock_that_was_set_back_has_no_silence(written, time):
    sound, samples = written(100, 101, 50, times=(100, 101, time))
    assert (sound.lost, list(samples)) == (0, [7, 7, 7])


def test_silence_between_runs_is_bounded_as_within_them(written, monkeypatch):
    monkeypatch.setattr(sound_stream, "MOST_SILENCE", 5)
    sound, samples = written(0, 4, 0, 0, times=(0, 4, 10, 10**6))
    assert list(samples) == [7, 0, 0, 0, 7, 0, 0, 7, 7]
    assert (sound.lost, sound.unfilled) == (3 + 5 + 10**6 - 11, 10**6 - 11 + 3)


def test_silence_is_bounded_over_all_gaps_and_what_is_lost_beyond_it_counted(written, monkeypatch):
    monkeypatch.setattr(sound_stream, "MOST_SILENCE", 5)
    sound, samples = written(0, 4, 10, 10**15)
    assert list(samples) == [7, 0, 0, 0, 7, 0, 0, 7, 7]
    assert sound.lost == 3 + 5 + 10**15 - 11
    assert sound.unfilled == sound.lost - 5


@pytest.mark.parametrize("firsts", [(0, 1, 2, 3), (0, 3)], ids=["sound", "silence"])
def test_more_than_a_file_can_hold_is_named_and_what_is_in_it_stays(written, monkeypatch, firsts):
    monkeypatch.setattr(sound_stream, "MOST_SOUND", 6)  # [B]
    with pytest.raises(OutputFailed, match=r"audio\.wav: more sound than the 4 GiB"):
        written(*firsts)


def test_a_file_of_the_most_sound_has_a_sound_head():
    assert 36 + sound_stream.MOST_SOUND < 1 << 32

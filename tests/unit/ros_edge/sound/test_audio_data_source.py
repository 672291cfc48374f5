# SPDX-License-Identifier: BSD-3-Clause
"""Sound of audio_common: a silence of its topic is a gap, and no command is heard across it."""

from itertools import pairwise
from queue import Empty
from types import SimpleNamespace

import numpy as np
import pytest
from audio_common_msgs.msg import AudioInfo

from tests.unit.voice_assist.support.fake_pipeline import commands, make, run
from tests.unit.voice_assist.support.fake_speech import say
from voice_assist.config import load_voice_config
from voice_assist.ros.other_messages import audio_data_source
from voice_assist.ros.other_messages.audio_data_source import AudioDataSource
from voice_assist.types import FULL_SCALE, RATE

BLOCK = 512  # samples
INFO = AudioInfo(channels=1, sample_rate=RATE, sample_format="S16LE", coding_format="wave")


def messages(sound, start):
    """A sound in messages, each with the time at which it came [s]."""
    pcm = np.rint(np.asarray(sound) * FULL_SCALE).astype("<i2")
    blocks = [pcm[at : at + BLOCK] for at in range(0, len(pcm) - BLOCK + 1, BLOCK)]
    return [(b.tobytes(), start + (n + 1) * BLOCK / RATE) for n, b in enumerate(blocks)]


@pytest.fixture
def frames_of(monkeypatch):
    """Frames of what comes; None stands for a silence that is noticed."""

    def hear(items):
        source = AudioDataSource(load_voice_config().audio.audio_data, print, print)
        source._subscribers = [SimpleNamespace(get_num_connections=lambda: 1)]
        waiting = list(items)

        def get(timeout):
            item = waiting.pop(0)
            if item is None:
                raise Empty
            return item

        source._queue = SimpleNamespace(get=get)
        monkeypatch.setattr(audio_data_source.rospy, "is_shutdown", lambda: not waiting)
        return list(source)

    return hear


def silenced(before, after, is_reported):
    """Two sounds with a silence of the publisher of 20 s between them."""
    first = messages(before, 100.0)
    info = [INFO] if is_reported else []
    return [*info, *first, None, *messages(after, first[-1][1] + 20.0)]


@pytest.mark.parametrize(("is_reported", "judging"), [(True, 0.0), (False, 1.0)])
def test_after_a_silence_the_count_of_samples_jumps_by_its_length(frames_of, is_reported, judging):
    quiet = np.zeros(3 * RATE)
    heard = frames_of(silenced(quiet, quiet, is_reported))
    jumps = [b.first_sample - a.next_sample for a, b in pairwise(heard)]
    assert [jump / RATE for jump in jumps if jump] == [pytest.approx(20.0 + judging, abs=0.1)]


@pytest.mark.parametrize("is_reported", [True, False])
def test_words_before_and_after_a_silence_are_no_command(frames_of, is_reported):
    judged = 0.0 if is_reported else 1.2  # [s] of quiet that is heard first, or swallowed
    before, after = say("pull", 0.5 + judged, 0.05), say("more", 0.05 + judged, 1.0)
    heard = frames_of(silenced(before, after, is_reported))
    assert commands(run(*make(), heard)) == []
    joined = frames_of([INFO, *messages(say("pull more"), 100.0)])
    assert commands(run(*make(), joined)) == ["pull more"]

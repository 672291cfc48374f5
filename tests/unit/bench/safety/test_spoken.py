# SPDX-License-Identifier: BSD-3-Clause
"""The judge of spoken stops counts from the end of the word, and reports what was not heard."""

from dataclasses import replace

import numpy as np
import pytest

from bench.safety.spoken.judge import SoundPiece, SpokenStop, end_of_word, figures
from voice_assist.types import RATE

CHUNK = RATE // 20
HEARD = SpokenStop("human", "one.wav", 0.04, True, 0.06, 0.07)


def clip(word, background=0.0):
    """A word of so many seconds in the middle of a second, with a background."""
    rng = np.random.default_rng(2)
    sound = background * rng.standard_normal(RATE)
    span = slice(round(0.2 * RATE), round((0.2 + word) * RATE))
    sound[span] += 0.2 * rng.standard_normal(span.stop - span.start)
    return sound.astype(np.float32)


def stream(said, at, seconds=2.0, late=0.0):
    """A quiet room in which a clip is said at a moment; all pieces but the first are late."""
    rng = np.random.default_rng(1)
    sound = 1e-3 * rng.standard_normal(round(seconds * RATE))
    begin = round(at * RATE)
    sound[begin : begin + len(said)] += said[: len(sound) - begin]
    blocks = sound.astype(np.float32).reshape(-1, CHUNK)
    return [SoundPiece(100.0 + 0.05 * i + (late if i else 0.0), b) for i, b in enumerate(blocks)]


@pytest.mark.parametrize("background", [0.0, 0.004])
@pytest.mark.parametrize("word", [0.25, 0.5])
@pytest.mark.parametrize("at", [0.0, 0.15, 0.73])
def test_the_word_ends_where_it_does_in_its_clip(at, word, background):
    said = clip(word, background)
    end = end_of_word(stream(said, at), said)
    assert end == pytest.approx(100.0 + at + 0.2 + word, abs=0.02)


def test_the_stamp_of_the_piece_it_ends_in_counts():
    said = clip(0.5)
    assert end_of_word(stream(said, 0.3, late=0.3), said) == pytest.approx(101.3, abs=0.02)


def test_a_word_that_was_not_sent_whole_has_an_end():
    said = clip(0.5)
    assert end_of_word(stream(said, 0.4, seconds=1.0), said) == pytest.approx(101.1, abs=0.02)


def test_without_sound_there_is_no_end():
    with pytest.raises(ValueError, match="no sound"):
        end_of_word([], clip(0.5))


def value(found, ending):
    (figure,) = [one for one in found if one.name.endswith(ending)]
    return figure


def test_what_was_not_heard_is_named_and_gives_no_time():
    missed = replace(HEARD, path="two.wav", received=None, setpoints=np.inf, joints=np.inf)
    found = figures([HEARD, missed])
    heard = value(found, "human: heard")
    assert heard.value == 50.0
    assert "two.wav" in heard.note and "one.wav" not in heard.note
    assert value(found, "arm and jaws at rest max").value == pytest.approx(70.0)


def test_a_stop_after_the_motion_was_over_is_heard_and_gives_no_time():
    found = figures([HEARD, replace(HEARD, is_moving=False, joints=0.0)])
    assert value(found, "human: heard").value == 100.0
    assert value(found, "came in motion").value == 1
    assert value(found, "arm and jaws at rest p50").value == pytest.approx(70.0)


def test_a_robot_that_did_not_come_to_rest_shows():
    found = figures([HEARD, replace(HEARD, joints=np.inf)])
    assert value(found, "it went on").value == 1
    assert value(found, "it went on").is_met is False
    assert value(figures([HEARD]), "it went on").is_met


def test_people_and_synthetic_voices_are_counted_apart():
    found = figures([HEARD, replace(HEARD, who="synthetic", received=None)])
    assert value(found, "human: heard").value == 100.0
    assert value(found, "synthetic: heard").value == 0.0
    assert not [f for f in found if "synthetic" in f.name and "at rest" in f.name]

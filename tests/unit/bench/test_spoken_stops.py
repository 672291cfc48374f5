# SPDX-License-Identifier: BSD-3-Clause
"""The judge of spoken stops counts from the end of the word, and tells what was not heard."""

from dataclasses import replace

import numpy as np
import pytest

from bench.safety.spoken_judge import Piece, SpokenStop, end_of_word, figures
from voice_assist.types import RATE

CHUNK = RATE // 20
HEARD = SpokenStop("human", "one.wav", 0.04, True, 0.06, 0.07)


def stream(speech_until, seconds=2.0, late=0.0):
    """A quiet room in which somebody speaks up to a moment; all pieces but the first are late."""
    rng = np.random.default_rng(1)
    sound = 1e-3 * rng.standard_normal(round(seconds * RATE))
    span = slice(round(0.5 * RATE), round(speech_until * RATE))
    sound[span] += 0.2 * rng.standard_normal(span.stop - span.start)
    blocks = sound.astype(np.float32).reshape(-1, CHUNK)
    return [Piece(100.0 + 0.05 * i + (late if i else 0.0), b) for i, b in enumerate(blocks)]


@pytest.mark.parametrize("end", [0.7, 0.95, 1.0, 1.43])
def test_the_word_ends_where_its_sound_does(end):
    assert end_of_word(stream(end)) == pytest.approx(100.0 + end, abs=0.02)


def test_the_stamp_of_the_piece_it_ends_in_counts():
    assert end_of_word(stream(1.02, late=0.3)) == pytest.approx(101.32, abs=0.02)


def test_a_word_in_the_last_piece_has_an_end():
    assert end_of_word(stream(1.0, seconds=1.0)) == pytest.approx(101.0, abs=0.02)


def test_without_sound_there_is_no_end():
    with pytest.raises(ValueError, match="no sound"):
        end_of_word([])


def value(found, ending):
    (figure,) = [one for one in found if one.name.endswith(ending)]
    return figure


def test_what_was_not_heard_is_named_and_gives_no_time():
    missed = replace(HEARD, path="two.wav", received=None, setpoints=np.inf, joints=np.inf)
    found = figures([HEARD, missed])
    heard = value(found, "human: heard")
    assert heard.value == 0.5
    assert "two.wav" in heard.note and "one.wav" not in heard.note
    assert value(found, "arm and jaws at rest max").value == pytest.approx(70.0)


def test_a_stop_after_the_motion_was_over_is_heard_and_gives_no_time():
    found = figures([HEARD, replace(HEARD, is_moving=False, joints=0.0)])
    assert value(found, "human: heard").value == 1.0
    assert value(found, "came in motion").value == 1
    assert value(found, "arm and jaws at rest p50").value == pytest.approx(70.0)


def test_a_robot_that_did_not_come_to_rest_shows():
    found = figures([HEARD, replace(HEARD, joints=np.inf)])
    assert value(found, "it went on").value == 1
    assert value(found, "it went on").is_met is False
    assert value(figures([HEARD]), "it went on").is_met


def test_people_and_synthetic_voices_are_told_apart():
    found = figures([HEARD, replace(HEARD, who="synthetic", received=None)])
    assert value(found, "human: heard").value == 1.0
    assert value(found, "synthetic: heard").value == 0.0
    assert not [f for f in found if "synthetic" in f.name and "at rest" in f.name]

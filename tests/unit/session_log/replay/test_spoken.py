# SPDX-License-Identifier: BSD-3-Clause
"""The sound of each utterance is cut out where it was said, with silence where it was lost."""

import numpy as np
import pytest

from session_log.errors import SessionLogError
from session_log.replay import spoken as spoken_room
from session_log.replay.spoken import AROUND, spoken
from support.story import START, Story, recording_of
from tests.unit.session_log.support.voice_recording import BLOCK, say, say_sound

RATE = 16000


def written(path, utterances, lost=()):
    """A session whose every block of sound holds its own number."""
    story = Story()
    for number in range(round(6.0 * RATE / BLOCK)):
        if number not in lost:
            say_sound(story, number * BLOCK / RATE, number * BLOCK, number + 1)
    for start, end, text, command in utterances:
        say(story, end, transcript=text, command=command, speech_start=start)
    recording_of(path, sorted(story.messages, key=lambda m: m.log_time))
    return path


def test_each_utterance_has_its_own_sound_and_time(tmp_path):
    said = [(1.0, 1.5, "tense", "tense"), (3.0, 3.4, "ten", "")]
    first, second = spoken(written(tmp_path / "session.mcap", said))
    assert (first.heard, first.command) == ("tense", "tense")
    assert (second.heard, second.command) == ("ten", "")
    assert first.time == pytest.approx(1.0, abs=0.001)
    assert len(first.samples) == round((0.5 + 2 * AROUND) * RATE)
    blocks = (np.arange(len(first.samples)) + round((1.0 - AROUND) * RATE)) // BLOCK + 1
    assert np.mean(first.samples == blocks) > 0.99


def test_lost_sound_is_silence(tmp_path):
    path = written(tmp_path / "session.mcap", [(1.0, 1.5, "tense", "tense")], lost=range(35, 40))
    (only,) = spoken(path)
    assert set(np.unique(only.samples)) & {36, 37, 38, 39, 40} == set()
    assert 0 in only.samples


def test_an_utterance_without_any_sound_is_left_out(tmp_path):
    path = written(tmp_path / "session.mcap", [(20.0, 21.0, "tense", "tense")])
    assert spoken(path) == []


@pytest.mark.parametrize(
    ("start", "end"),
    [(1.0 - START * 1e-9, 2.0), (2.0, 2.0 + 3600.0), (2.0, 1.0 - START * 1e-9), (2.5, 2.1)],
    ids=["from 1970 to now", "an hour forward", "back to 1970", "a little back"],
)
def test_an_utterance_during_which_the_clock_was_set_is_left_out(tmp_path, start, end):
    story = Story()
    for number in range(round(6.0 * RATE / BLOCK)):
        say_sound(story, number * BLOCK / RATE, number * BLOCK, number + 1)
    say(story, 1.5, transcript="first", speech_start=1.0)
    say(story, 2.0, transcript="odd", speech_start=start, speech_end=end)
    say(story, 3.4, transcript="last", speech_start=3.0)
    recording_of(tmp_path / "s.mcap", sorted(story.messages, key=lambda m: m.log_time))
    assert [one.heard for one in spoken(tmp_path / "s.mcap")] == ["first", "last"]


def test_the_longest_utterance_that_the_settings_allow_is_kept(tmp_path):
    said = [(1.0, 29.0, "talk", ""), (3.0, 3.4, "ten", "")]
    found = spoken(written(tmp_path / "session.mcap", said))
    assert [one.heard for one in found] == ["talk", "ten"]


def test_a_block_is_given_only_to_the_utterances_near_it(tmp_path, monkeypatch):
    taken = []

    class Window(spoken_room._Window):
        def take(self, sound):
            taken.append((self.utterance.transcript, sound.first_sample // BLOCK))
            super().take(sound)

    monkeypatch.setattr(spoken_room, "_Window", Window)
    said = [(3.0, 3.4, "second", ""), (1.0, 1.5, "first", "")]
    spoken(written(tmp_path / "session.mcap", said))
    for start, end, text, _ in said:
        blocks = [block for transcript, block in taken if transcript == text]
        low, high = ((moment * RATE) / BLOCK for moment in (start - AROUND, end + AROUND))
        assert low - 2 < min(blocks) <= low and high - 1 <= max(blocks) < high + 1


def test_of_utterances_at_one_time_each_has_the_whole_of_its_sound(tmp_path):
    said = [(1.0, 3.0, "long", ""), (1.2, 1.4, "short", ""), (2.6, 3.4, "late", "")]
    path = written(tmp_path / "session.mcap", said)
    for one, (start, end, text, _) in zip(spoken(path), said, strict=True):
        assert one.heard == text and len(one.samples) == round((end - start + 2 * AROUND) * RATE)
        blocks = (np.arange(len(one.samples)) + round((start - AROUND) * RATE)) // BLOCK + 1
        assert np.mean(one.samples == blocks) > 0.99


def test_what_is_no_session_is_refused(tmp_path):
    with pytest.raises(SessionLogError):
        spoken(tmp_path)
    (tmp_path / "bin.mcap").write_bytes(b"x" * 5000)
    with pytest.raises(SessionLogError, match=r"bin\.mcap: holds no readable message"):
        spoken(tmp_path / "bin.mcap")

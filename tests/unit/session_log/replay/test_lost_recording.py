# SPDX-License-Identifier: BSD-3-Clause
"""A replay names what is lost from a recording, and counts no difference that comes of it."""

import re

from mcap.reader import make_reader

from support.story import Story
from tests.unit.session_log.support.fake_pipeline import MADE, PLANS
from tests.unit.session_log.support.voice_recording import (
    ACTIVE,
    BLOCK,
    SAME,
    block,
    hears,
    note,
    ordinary,
    play,
    say,
    write,
)


def test_sound_lost_from_the_file_is_said_and_what_follows_it_is_not_counted(tmp_path, replayed):
    story = Story()
    story.say(2.0, "/voice_assist/mode", "voice_assist/Mode", **ACTIVE)
    play(story, 0.0, 20.0)
    say(story, 5.0)
    say(story, 18.0)
    PLANS.append({block(7.0): [hears(7.0)], block(18.2): [hears(18.0)]})
    path = write(tmp_path / "session.mcap", story, lost=(4.0, 6.0))
    code, out, _, result = replayed(path)
    assert code == 0
    assert "lost: 1 utterances that were recorded" in out
    assert "lost: 2.02 s of sound in front of sample 96256" in out
    (found,) = result["sessions"][0]["differences"]
    assert found["excuse"].endswith("is lost") and found["kinds"] == ["extra"]
    (mode,) = MADE[0].modes
    assert mode[1:] == ("active", "hey robot")


def test_a_difference_long_after_lost_sound_counts(tmp_path, replayed):
    story = Story()
    play(story, 0.0, 20.0)
    say(story, 18.0)
    code, out, _, _ = replayed(write(tmp_path / "session.mcap", story, lost=(4.0, 6.0)))
    assert code == 1 and "#1 at 18.20 s: missing\n" in out


def test_a_gap_that_the_node_had_too_is_no_loss(tmp_path, replayed):
    story = Story()
    skip = range(block(4.0), block(5.0), BLOCK)
    play(story, 0.0, 10.0, skip=skip)
    note(story, 5.1, f"lost {block(5.0)}")
    note(story, 9.9, "heard 159000")
    PLANS.append({block(6.0): [hears(6.0)]})
    code, out, _, _ = replayed(write(tmp_path / "session.mcap", story))
    assert code == 1 and "lost:" not in out and "after #0 at 6.20 s: extra\n" in out
    assert MADE[0].modes == []


def test_a_recording_that_begins_late_says_so_and_takes_the_mode(tmp_path, replayed):
    story = Story()
    story.say(0.5, "/voice_assist/mode", "voice_assist/Mode", **ACTIVE)
    play(story, 4.0, 10.0)
    code, out, _, _ = replayed(write(tmp_path / "session.mcap", story))
    assert code == 0 and "lost: 4.00 s of sound before the first" in out
    assert MADE[0].modes == [(None, "active", "hey robot")]


def test_what_a_second_run_lost_before_its_first_sound_excuses_nothing_of_the_first(
    tmp_path, replayed
):
    story = Story()
    play(story, 0.0, 10.0)
    say(story, 3.0)
    play(story, 0.1, 5.0, start=12.0)
    say(story, 14.0)
    PLANS.extend([{}, {}])
    code, out, _, result = replayed(write(tmp_path / "session.mcap", story))
    assert code == 1 and "lost: 0.10 s of sound before the first 1536" in out
    first, second = result["sessions"][0]["differences"]
    assert first["excuse"] == "" and second["excuse"].endswith("is lost")


def middle(path):
    """Place inside the middle chunk of a recording [B]."""
    with path.open("rb") as file:
        chunks = make_reader(file).get_summary().chunk_indexes
    return chunks[len(chunks) // 2].chunk_start_offset + 40


def test_a_truncated_file_is_heard_as_far_as_it_goes(tmp_path, replayed):
    PLANS.append(SAME)
    whole = ordinary(tmp_path / "whole.mcap")
    path = tmp_path / "cut.mcap"
    path.write_bytes(whole.read_bytes()[: middle(whole)])
    code, out, _, result = replayed(path)
    assert code == 0 and "cut off inside a record" in out
    assert 4.0 < result["sessions"][0]["sound"] < 6.0
    assert result["sessions"][0]["recorded"] == 1


def test_a_damaged_stretch_is_said_and_the_rest_is_heard(tmp_path, replayed):
    PLANS.append(SAME)
    place = middle(ordinary(tmp_path / "session.mcap"))
    content = bytearray((tmp_path / "session.mcap").read_bytes())
    content[place : place + 2_000] = bytes(2_000)
    (tmp_path / "session.mcap").write_bytes(content)
    code, out, _, result = replayed(tmp_path / "session.mcap")
    assert re.search(r"lost: \d+ bytes at \d+", out) and "s of sound in front of sample" in out
    assert code == 0 and result["sessions"][0]["sound"] > 9.0


def test_what_the_node_may_have_ended_before_is_not_counted(tmp_path, replayed):
    story = Story()
    play(story, 0.0, 10.0)
    note(story, 5.0, "heard 80000")
    PLANS.append({block(4.0): [hears(3.9)], block(8.0): [hears(7.9)]})
    code, _, _, result = replayed(write(tmp_path / "session.mcap", story))
    assert code == 1
    early, late = result["sessions"][0]["differences"]
    assert early["excuse"] == "" and "may have ended" in late["excuse"]


def test_without_notes_only_the_very_end_is_not_counted(tmp_path, replayed):
    story = Story()
    play(story, 0.0, 10.0)
    PLANS.append({block(8.0): [hears(7.9)], block(9.9): [hears(9.7)]})
    code, _, _, result = replayed(write(tmp_path / "session.mcap", story))
    excuses = [d["excuse"] for d in result["sessions"][0]["differences"]]
    assert code == 1 and excuses == ["", "the recording ends there"]

# SPDX-License-Identifier: BSD-3-Clause
"""Begin, length and rates of a recording, whatever happened to the clock."""

import pytest

from session_log.mcap_file.reader import SessionReader
from session_log.mcap_file.records import MAGIC
from session_log.mcap_file.summary import read_summary
from session_log.types import Message, MessageSource
from support.story import recording_of
from tests.unit.session_log.support.foreign import NOW, write_foreign

TENTH = 10**8  # [ns]


def messages(set_back):
    """Of /t 10 Hz for 10 s, of /late in the last 4 s; before some, the clock is set back [s]."""
    now, t, late = NOW, *(MessageSource(n, "a/B", "99", "int8 x") for n in ("/t", "/late"))
    for k in range(101):
        now -= set_back.get(k, 0) * 10**9
        if k > 60:
            yield Message(late, b"x", now + k * TENTH, k - 60)
        yield Message(t, b"x", now + k * TENTH, k + 1)


@pytest.mark.parametrize(
    "set_back", [{}, {50: 3}, {50: 3600}, {30: 60, 80: 7}], ids=["never", "3 s", "1 h", "twice"]
)
def test_length_and_rates_cover_what_was_recorded_though_the_clock_was_set_back(tmp_path, set_back):
    result = read_summary(recording_of(tmp_path / "s.mcap", messages(set_back)))
    now = NOW
    for step, (k, seconds) in zip(result.clock_steps, set_back.items(), strict=True):
        before, now = now + (k - 1) * TENTH, now - seconds * 10**9
        assert (step.before, step.after) == (before, now + k * TENTH)
        assert str(step).startswith(f"the clock was set back by {seconds - 0.1:.1f} s at 2026-")
    assert result.start == NOW
    unseen = 0.1 * len(set_back)  # [s] between the two messages around a step
    assert result.duration == pytest.approx(10.0 - unseen)
    assert result.topics["/t"].rate == pytest.approx(10.0, rel=0.03)
    assert result.topics["/late"].rate == pytest.approx(10.0, rel=0.03)


@pytest.mark.parametrize(("forward", "is_named"), [(3, False), (6, True), (3600, True)])
def test_a_silence_of_seconds_is_named_as_a_clock_that_was_set_forward_or_none(
    tmp_path, forward, is_named
):
    result = read_summary(recording_of(tmp_path / "s.mcap", messages({50: -forward})))
    words = f"the clock was set forward by {forward + 0.1:.1f} s at 2026-"
    assert [str(step).startswith(words) for step in result.clock_steps] == [True] * is_named
    assert all(str(s).endswith(", or nothing was recorded meanwhile") for s in result.clock_steps)


def test_what_is_missing_is_said_though_the_header_is_lost(tmp_path):
    source = MessageSource("/t", "a/B", "99", "int8 x")
    path = recording_of(tmp_path / "s.mcap", [Message(source, b"x", NOW, k) for k in (1, 4)]).path
    content = bytearray(path.read_bytes())
    content[len(MAGIC)] = 0xFF  # what the first record is
    path.write_bytes(content)
    result = read_summary(SessionReader(path))
    assert (result.condition.library, result.missing) == ("", 2)


def test_times_of_another_writer_need_no_order(tmp_path):
    times = [NOW + k * 10**9 for k in (6, 8, 0, 2, 4)]
    path = write_foreign(tmp_path / "s.mcap", times=times)
    result = read_summary(SessionReader(path))
    assert (result.start, result.duration, result.clock_steps) == (NOW, 8.0, [])
    assert result.topics["/t"].rate == 0.5

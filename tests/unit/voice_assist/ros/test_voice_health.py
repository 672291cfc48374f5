# SPDX-License-Identifier: BSD-3-Clause
"""What the voice node says of itself: before the first sound, while all is well, and behind."""

from types import SimpleNamespace

import pytest
from diagnostic_msgs.msg import DiagnosticStatus

from tests.unit.voice_assist.support.fake_pipeline import commands, make, run
from tests.unit.voice_assist.support.fake_speech import frames, say
from voice_assist.config import load_voice_config
from voice_assist.errors import ModelError, VoiceError
from voice_assist.ros import diagnostics, voice_node
from voice_assist.types import HearingFault, Lost

LIMIT = 0.5  # [s]


def healthy(source="none", **health):
    return diagnostics.VoiceHealth("none", source, 60, trouble="", **health)


def summary(now, **health):
    health = diagnostics.VoiceHealth(model="none", source="none", capacity=60, **health)
    return diagnostics._summary(health, now, LIMIT)


def test_an_open_source_without_sound_so_far_is_not_called_slow_nor_one_that_starts():
    level, words, fault = summary(10.0, trouble="")
    assert level == DiagnosticStatus.ERROR and words.startswith("no sound has come yet")
    assert fault is HearingFault.NO_SOUND_YET
    assert summary(10.0) == (DiagnosticStatus.ERROR, "starting", HearingFault.NO_SOUND)


def test_fresh_sound_is_listening_and_old_or_late_sound_is_an_error():
    assert summary(10.0, trouble="", frame_done=9.9) == (DiagnosticStatus.OK, "listening", None)
    for late in ({"frame_done": 9.4}, {"frame_done": 9.9, "behind": 0.6}):
        level, _, fault = summary(10.0, trouble="", **late)
        assert level == DiagnosticStatus.ERROR and fault is HearingFault.SLOW


@pytest.mark.parametrize(("now", "is_slow"), [(100.0, True), (104.9, True), (105.1, False)])
def test_a_spotter_that_loses_sound_is_named_for_a_while(now, is_slow):
    health = healthy(frame_done=now)
    for dropped in (0, 0, 1):
        health.note_spotter(dropped, 100.0)
    health.note_spotter(1, 104.0)
    level, words, fault = diagnostics._summary(health, now, LIMIT)
    assert (fault is HearingFault.SPOTTER_SLOW) == is_slow
    assert level == (DiagnosticStatus.ERROR if is_slow else DiagnosticStatus.OK)
    assert ("the recogniser alone hears a stop" in words) == is_slow
    assert health.would_hear(now, LIMIT)


@pytest.mark.parametrize(
    ("since", "words", "fault"),  # [s] since the last frame came
    [
        (0.6, "no sound for 0.6 s, allowed below 0.5 s", HearingFault.NO_SOUND),
        (0.1, "recognition does not keep up", HearingFault.SLOW),
    ],
)
def test_sound_that_ends_is_not_called_slow_recognition(monkeypatch, since, words, fault):
    steady = SimpleNamespace(monotonic=lambda: 1000.0)
    monkeypatch.setattr(diagnostics, "time", steady)
    health = healthy(frame_done=9.4)
    health.sounded(-40.0, 0.0)
    steady.monotonic = lambda: 1000.0 + since
    level, said, found = diagnostics._summary(health, 10.0, LIMIT)
    assert level == DiagnosticStatus.ERROR and found is fault
    assert said == f"{words}: a spoken stop is not heard"
    assert not health.would_hear(10.0, LIMIT)


@pytest.mark.parametrize(
    ("source", "speed", "error"),
    [
        ("wav", 0.0, r"audio.wav.speed is 0, .* above 0"),
        ("wav", 0.5, "is loaded"),
        ("microphone", 0.0, "is loaded"),
    ],
)
def test_a_recording_of_no_pace_is_refused_by_the_node(monkeypatch, source, speed, error):
    def load(config):
        raise ModelError("is loaded")

    monkeypatch.setattr(voice_node, "make_recognizer", load)
    wav = {"audio__wav__path": "x.wav", "audio__wav__speed": speed}
    with pytest.raises(VoiceError, match=error):
        voice_node.VoiceNode(load_voice_config(audio__source=source, **wav))


@pytest.mark.parametrize(
    ("source", "behind", "hears"),
    [
        *(("none", -0.4, True), ("none", -0.6, False), ("none", 0.6, False)),
        ("wav", -50.0, True),  # a recording that is played as fast as can be
    ],
)
def test_sound_that_is_stamped_ahead_counts_as_much_as_late_sound(source, behind, hears):
    health = healthy(source, frame_done=10.0, behind=behind)
    assert health.would_hear(10.1, LIMIT) is hears


def test_sound_that_is_stamped_ahead_is_named_and_not_called_slow():
    level, words, fault = summary(10.0, trouble="", frame_done=9.9, behind=-8.0)
    assert level == DiagnosticStatus.ERROR and fault is HearingFault.CLOCKS
    assert words == "the sound is stamped 8.0 s ahead, allowed 0.5 s: set the clocks"


def test_clocks_that_differ_end_the_heartbeat_and_are_named_until_they_agree():
    health = healthy(frame_done=10.0)
    health.note_clocks("1.3 s ahead")
    assert not health.would_hear(10.1, LIMIT)
    error = DiagnosticStatus.ERROR, "1.3 s ahead", HearingFault.CLOCKS
    assert diagnostics._summary(health, 10.1, LIMIT) == error
    health.note_clocks("")
    assert health.would_hear(10.1, LIMIT)


def torn(sound, deaf_after=1.5):
    """Health after sound with gaps, its events, and when the last gap was noticed [s]."""
    pipeline, clock = make()
    health, events, last = healthy(), [], None
    for frame in sound:
        found = run(pipeline, clock, [frame])
        health.frame_done = clock.now
        for event in found:
            if isinstance(event, Lost):
                health.note_gap(event.samples, clock.now, deaf_after)
                last = clock.now
        events += found
    return health, events, last


def test_sound_with_a_gap_every_quarter_second_takes_no_stop_and_is_named():
    whole = frames(say("stop 0.8 stop 0.8 stop 0.8"))
    assert "stop" in commands(run(*make(), whole))
    health, events, last = torn([f for n, f in enumerate(whole) if n % 8])
    assert commands(events) == []
    assert not health.would_hear(last, 1.5)
    level, words, fault = diagnostics._summary(health, last, 1.5)
    assert level == DiagnosticStatus.ERROR and fault is HearingFault.TORN
    assert words.startswith("the sound is torn, 3 gaps within 0.5 s, allowed 2 within 2 s")
    health.frame_done = last + 1.6
    assert not health.would_hear(last + 1.4, 1.5)
    assert health.would_hear(last + 1.6, 1.5)


@pytest.mark.parametrize("gaps", [(), (30,), (30, 40)])
def test_one_gap_or_two_are_no_torn_sound(gaps):
    health, _, _ = torn([f for n, f in enumerate(frames(say("stop 0.8"))) if n not in gaps])
    assert health.lost == 512 * len(gaps)
    assert health.would_hear(health.frame_done, 1.5)


@pytest.mark.parametrize(
    "moments",
    [(10.0, 11.5, 13.0, 14.5), (1000.0, 1005.0, 10.0)],  # the clock was set back
)
def test_gaps_that_leave_room_for_a_stop_are_no_torn_sound(moments):
    health = healthy()
    for moment in moments:
        health.note_gap(512, moment, 1.5)
        assert not health.is_torn(moment, 1.5)


def test_torn_sound_stays_torn_until_no_gap_has_come_for_long_enough():
    health = healthy()
    for moment in (10.0, 10.5, 11.0, 12.4, 13.8):  # the last come seldom
        health.note_gap(512, moment, 1.5)
    assert health.is_torn(15.2, 1.5) and not health.is_torn(15.4, 1.5)


def test_what_is_said_of_one_microphone_is_not_said_of_the_next():
    health = diagnostics.VoiceHealth(model="none", source="none", capacity=60)
    health.note_microphone("headset")
    health.remark = "channel 2 is turned over"
    health.note_microphone("headset")
    assert health.remark
    health.note_microphone("desk")
    assert (health.microphone, health.remark) == ("desk", "")


def test_what_is_wrong_goes_before_a_remark():
    heard = {"trouble": "", "frame_done": 9.9, "remark": "channel 2 is turned over"}
    assert summary(10.0, **heard)[1] == heard["remark"]
    assert summary(10.0, **heard, queued=31)[1] == "recognition falls behind"
    assert summary(10.0, **heard, clipped=0.5)[1].startswith("the microphone clips")

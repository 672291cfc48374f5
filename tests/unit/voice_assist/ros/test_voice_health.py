# SPDX-License-Identifier: BSD-3-Clause
"""What the voice node says of itself: before the first sound, while all is well, and behind."""

from importlib import import_module
from pkgutil import extend_path

from diagnostic_msgs.msg import DiagnosticStatus

import voice_assist
from voice_assist.types import HearingFault

voice_assist.__path__ = extend_path(voice_assist.__path__, voice_assist.__name__)
diagnostics = import_module("voice_assist.ros.diagnostics")

LIMIT = 0.5  # [s]


def told(now, **health):
    health = diagnostics.VoiceHealth(model="none", source="none", capacity=60, **health)
    return diagnostics._summary(health, now, LIMIT)


def test_an_open_source_without_sound_so_far_is_not_called_slow():
    level, words, fault = told(10.0, trouble="")
    assert level == DiagnosticStatus.ERROR and words.startswith("no sound has come yet")
    assert fault is HearingFault.NO_SOUND_YET


def test_what_is_wrong_with_the_source_goes_before():
    assert told(10.0) == (DiagnosticStatus.ERROR, "starting", HearingFault.NO_SOUND)


def test_fresh_sound_is_listening_and_old_or_late_sound_is_an_error():
    assert told(10.0, trouble="", frame_done=9.9) == (DiagnosticStatus.OK, "listening", None)
    for late in ({"frame_done": 9.4}, {"frame_done": 9.9, "behind": 0.6}):
        level, _, fault = told(10.0, trouble="", **late)
        assert level == DiagnosticStatus.ERROR and fault is HearingFault.SLOW


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
    assert told(10.0, **heard)[1] == heard["remark"]
    assert told(10.0, **heard, queued=31)[1] == "recognition falls behind"
    assert told(10.0, **heard, clipped=0.5)[1].startswith("the microphone clips")

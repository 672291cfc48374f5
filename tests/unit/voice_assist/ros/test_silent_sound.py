# SPDX-License-Identifier: BSD-3-Clause
"""Sound of audio_common that ends is noticed, whatever else its node publishes."""

import threading
from dataclasses import replace
from types import SimpleNamespace

from audio_common_msgs.msg import AudioInfo

from support.waiting import PATIENCE
from voice_assist.config import load_voice_config
from voice_assist.ros.other_messages import audio_data_source
from voice_assist.ros.other_messages.audio_data_source import AudioDataSource
from voice_assist.types import RATE

INFO = AudioInfo(channels=1, sample_rate=RATE, sample_format="S16LE", coding_format="wave")
LOST_AFTER = 0.3  # [s]


def test_a_format_that_is_said_again_and_again_is_no_sound(monkeypatch):
    config = replace(load_voice_config().audio.audio_data, lost_after=LOST_AFTER)
    reports, is_over, callbacks = [], threading.Event(), {}

    def report(words):
        reports.append(words)
        is_over.set()

    def subscribe(name, kind, callback):
        callbacks[kind] = callback
        return SimpleNamespace(get_num_connections=lambda: 1, unregister=lambda: None)

    fake = SimpleNamespace(is_shutdown=is_over.is_set, resolve_name=lambda name: f"/{name}")
    monkeypatch.setattr(audio_data_source, "rospy", fake)

    def say_format():
        while not is_over.wait(LOST_AFTER / 10.0):
            callbacks[AudioInfo](INFO)

    with AudioDataSource(config, report, subscribe) as source:
        saying = threading.Thread(target=say_format, daemon=True)
        saying.start()
        hearing = threading.Thread(target=lambda: list(source), daemon=True)
        hearing.start()
        hearing.join(PATIENCE)
        heard = list(reports)
        is_over.set()
        hearing.join(PATIENCE)
    assert heard == [f"no sound on /{config.name} for 0.3 s"]

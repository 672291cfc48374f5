# SPDX-License-Identifier: BSD-3-Clause
import os
import subprocess
from unittest.mock import Mock

import pytest

from tests.unit.voice_assist.support.fake_speech import FakeRecognizer
from voice_assist.assembly import KERNEL_CACHE, MAX_KERNELS, limit_torch, make_pipeline, make_source
from voice_assist.audio.capture import pulse
from voice_assist.audio.wav_file import WavFile
from voice_assist.config import load_voice_config
from voice_assist.errors import AudioError
from voice_assist.types import Mode
from voice_assist.vad.detector import EnergyDetector, make_detector


def test_the_pipeline_takes_the_detector_of_the_settings():
    config = load_voice_config(audio__vad__detector="energy")
    assert isinstance(make_detector(config.audio.vad), EnergyDetector)
    pipeline = make_pipeline(config, lambda: 0.0, FakeRecognizer())
    assert pipeline.state.mode is Mode.STANDBY


@pytest.mark.parametrize(("before", "after"), [(None, str(MAX_KERNELS)), ("7", "7")])
def test_code_that_is_kept_for_lengths_of_sound_is_bounded(monkeypatch, before, after):
    monkeypatch.setenv(KERNEL_CACHE, before or "")
    if before is None:
        monkeypatch.delenv(KERNEL_CACHE)
    limit_torch(load_voice_config())
    assert os.environ[KERNEL_CACHE] == after


def test_the_source_is_the_one_of_the_settings_and_a_topic_is_left_to_the_node():
    config = load_voice_config(audio__source="wav", audio__wav__path="x.wav").audio
    source = make_source(config, lambda: 0.0, lambda _: False, lambda _: None)
    assert isinstance(source, WavFile)
    config = load_voice_config(audio__source="topic").audio
    with pytest.raises(AudioError, match="only in the node"):
        make_source(config, lambda: 0.0, lambda _: False, lambda _: None)


def test_sources_of_pulseaudio_are_read_from_its_list(monkeypatch):
    rows = "0\tsurgeon.monitor\tmodule\ts16le 1ch 16000Hz\tIDLE"
    rows += "\n1\talsa_input.usb\tmodule\ts24le 2ch 48000Hz\tIDLE"
    answers = {"list": rows, "get-default-source": "alsa_input.usb\n"}

    def run(words, **__):
        return subprocess.CompletedProcess([], 0, stdout=answers[words[1]].encode())

    monkeypatch.setattr(pulse.shutil, "which", lambda _: "pactl")
    monkeypatch.setattr(pulse.subprocess, "run", run)
    monitor, usb = pulse.pulse_sources()
    assert monitor == pulse.Source("surgeon.monitor", 1, is_default=False)
    assert usb == pulse.Source("alsa_input.usb", 2, is_default=True)
    answers["get-default-source"] = "surgeon.monitor\n"
    assert not any(source.is_default for source in pulse.pulse_sources())


def test_without_pactl_or_an_answer_there_are_no_sources(monkeypatch):
    silent = Mock(side_effect=subprocess.TimeoutExpired("pactl", 1.0))
    monkeypatch.setattr(pulse.subprocess, "run", silent)
    for program in (None, "pactl"):
        monkeypatch.setattr(pulse.shutil, "which", lambda _, found=program: found)
        assert pulse.pulse_sources() == ()

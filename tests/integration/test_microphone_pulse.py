# SPDX-License-Identifier: BSD-3-Clause
"""The microphone against a real PulseAudio server whose null sinks are the devices."""

import os
import subprocess
import threading
import time
from contextlib import ExitStack

import numpy as np
import pytest
import soundfile
from scipy.signal import hilbert

from demo.virtual_microphone import VirtualMicrophone
from support.waiting import PATIENCE, wait_until
from voice_assist.audio.capture.microphone import Microphone
from voice_assist.audio.capture.portaudio import PortAudio
from voice_assist.audio.source import level_db
from voice_assist.config import load_voice_config
from voice_assist.types import RATE

START = 15.0  # [s] allowed for the server to answer


@pytest.fixture(scope="module")
def server():
    """Environment of a PulseAudio server that only this file uses."""
    with ExitStack() as stack:
        try:
            running = stack.enter_context(VirtualMicrophone("other", RATE, START))
        except OSError as error:
            pytest.skip(f"no PulseAudio server: {error}")
        before = dict(os.environ)
        os.environ.update(running.environment)
        try:
            yield running
        finally:
            os.environ.clear()
            os.environ.update(before)


@pytest.fixture
def surgeon(server):
    """A virtual microphone `surgeon.monitor`, 44.1 kHz and stereo as cheap ones are."""
    added = Sink("surgeon", 44_100)
    yield added
    added.remove()


class Sink:
    """A null sink; what is played into it is heard by its monitor."""

    def __init__(self, name, rate):
        self.name, self.rate = name, rate
        self.add()

    def add(self):
        self.load("module-null-sink", f"sink_name={self.name}", f"rate={self.rate}")

    def load(self, *module):
        words = ["pactl", "load-module", *module]
        done = subprocess.run(words, capture_output=True, text=True, check=True)
        self.module = done.stdout.strip()

    def remove(self):
        subprocess.run(["pactl", "unload-module", self.module], capture_output=True)

    def play(self, path):
        words = ["paplay", "--latency-msec=30", f"--device={self.name}", str(path)]
        return subprocess.Popen(words)


class Listener:
    """Reads a microphone in a thread."""

    def __init__(self, device):
        self.frames, self.reports = [], []
        self._over = threading.Event()
        config = load_voice_config(
            audio__microphone__device=device, audio__microphone__retry_after=0.3
        )
        arguments = (config.audio.microphone, PortAudio(), time.time, self._over.wait)
        self._microphone = Microphone(*arguments, self.reports.append)
        self._thread = threading.Thread(target=self._read, daemon=True)

    @property
    def remark(self):
        return self._microphone.remark

    def _read(self):
        with self._microphone as microphone:
            for frame in microphone:
                self.frames.append(frame)

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *_):
        self._over.set()
        self._thread.join(PATIENCE)

    def wait_until(self, is_true):
        wait_until(is_true, f"{len(self.frames)} frames, {self.reports}")

    def hears(self, count):
        wanted = len(self.frames) + count
        self.wait_until(lambda: len(self.frames) >= wanted)


@pytest.fixture(scope="module")
def tone(tmp_path_factory):
    path = tmp_path_factory.mktemp("tone") / "tone.wav"
    time_ = np.arange(48_000 * 4) / 48_000
    soundfile.write(path, 0.3 * np.sin(2 * np.pi * 440 * time_), 48_000)
    return path


def test_the_sources_of_the_server_are_listed_by_name(surgeon):
    names = [device.name for device in PortAudio().devices()]
    assert "pulse:surgeon.monitor" in names and "pulse:other.monitor" in names


def test_sound_played_into_a_source_is_heard_at_16_khz_with_its_pitch(surgeon, tone):
    with Listener("pulse:surgeon.monitor") as listener:
        listener.hears(5)
        player = surgeon.play(tone)
        listener.wait_until(lambda: any(level_db(f.samples) > -20 for f in listener.frames))
        listener.hears(30)
        player.kill()
        player.wait()
    loud = [f.samples for f in listener.frames if level_db(f.samples) > -20]
    sound = np.concatenate(loud[3:20])
    turned = np.diff(np.unwrap(np.angle(hilbert(sound))))  # [rad] from one sample to the next
    pitch = np.median(turned) * RATE / (2.0 * np.pi)  # which a lost piece does not change
    assert pitch == pytest.approx(440.0, abs=3.0)


def test_channels_of_opposite_sign_are_heard_and_remarked(surgeon, tmp_path):
    tone = 0.3 * np.sin(2 * np.pi * 440 * np.arange(48_000 * 4) / 48_000)
    soundfile.write(tmp_path / "balanced.wav", np.stack([tone, -tone], axis=1), 48_000)
    with Listener("pulse:surgeon.monitor") as listener:
        listener.hears(5)
        player = surgeon.play(tmp_path / "balanced.wav")
        listener.wait_until(lambda: any(level_db(f.samples) > -16 for f in listener.frames))
        player.kill()
        player.wait()
        assert "opposite sign" in listener.remark


def test_a_source_that_goes_is_reported_never_replaced_and_taken_up_again(surgeon, tone):
    with Listener("pulse:surgeon.monitor") as listener:
        listener.hears(10)
        surgeon.remove()
        listener.wait_until(lambda: any("pulse:other.monitor" in r for r in listener.reports))
        heard = len(listener.frames)
        time.sleep(1.0)
        assert len(listener.frames) == heard, "nothing is heard from another source"
        surgeon.add()
        listener.hears(10)
    assert listener.reports[-1] == ""
    jumps = np.diff([f.first_sample for f in listener.frames])
    assert jumps.max() > RATE, "the time without sound is a gap"


@pytest.fixture
def plugged(server):
    """A microphone that is the default, to be unplugged by a call of its `remove`."""
    room = Sink("room", 48_000)
    plugged = Sink("headset", 48_000)
    plugged.remove()
    plugged.load("module-remap-source", "master=room.monitor", "source_name=headset")
    subprocess.run(["pactl", "set-default-source", "headset"], check=True)
    yield plugged
    plugged.remove()
    room.remove()


def test_the_default_that_is_unplugged_is_waited_for_and_no_monitor_is_taken(plugged):
    with Listener("") as listener:
        listener.hears(10)
        plugged.remove()
        listener.wait_until(lambda: any("headset': not found" in r for r in listener.reports))
        heard = len(listener.frames)
        time.sleep(1.0)
        assert len(listener.frames) == heard
        assert listener.reports[-1].startswith("microphone 'pulse:headset'")


def test_a_missing_source_is_named_with_those_that_exist(server):
    with Listener("pulse:nobody.monitor") as listener:
        listener.wait_until(lambda: listener.reports)
    assert "microphone 'pulse:nobody.monitor': not found" in listener.reports[0]
    assert "'pulse:other.monitor'" in listener.reports[0]
    assert listener.frames == []


def test_another_program_may_hear_the_same_source(surgeon):
    words = ["parec", "--device=surgeon.monitor", "--rate=16000", "--channels=1", "--raw"]
    with subprocess.Popen(words, stdout=subprocess.PIPE) as other:
        with Listener("pulse:surgeon.monitor") as listener:
            listener.hears(20)
            assert len(other.stdout.read(8192)) == 8192
        other.kill()
    assert not any(listener.reports), listener.reports

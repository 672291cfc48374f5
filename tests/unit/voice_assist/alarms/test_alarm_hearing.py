# SPDX-License-Identifier: BSD-3-Clause
"""The microphone hears the alarms: none is a command, and "stop" is heard over them."""

import shutil

import numpy as np
import pytest

from tests.unit.voice_assist.recognizer.test_recognizer import say
from tests.unit.voice_assist.support.fake_pipeline import StreamClock, commands, run
from tests.unit.voice_assist.support.fake_speech import frames, silence
from voice_assist.alarms.earcons import samples_of
from voice_assist.alarms.types import Earcon
from voice_assist.assembly import make_pipeline, make_spotter
from voice_assist.config import load_voice_config
from voice_assist.types import RATE, Mode

needs_espeak = pytest.mark.skipif(shutil.which("espeak-ng") is None, reason="needs espeak-ng")
SPEECH = 0.08  # rms of speech
SNR = 0.0  # [dB] of "stop" over the alarm: as loud as the alarm
CONFIG = load_voice_config()


@pytest.fixture(scope="module")
def hear(base):
    """The pipeline as shipped, active so that all commands count; gives the commands it takes."""
    clock, (spotter, _) = StreamClock(), make_spotter(CONFIG.spotter)
    pipeline = make_pipeline(CONFIG, clock, base, spotter)

    def heard(sound):
        pipeline.reset()
        pipeline.set_mode(Mode.ACTIVE, "test")
        whole = np.concatenate([silence(0.5), sound, silence(1.0)])
        return commands(run(pipeline, clock, frames(whole.astype(np.float32))))

    return heard


@pytest.mark.parametrize("level_db", [-6.0, -26.0, -40.0])
@pytest.mark.parametrize("earcon", Earcon)
def test_no_alarm_is_a_command(hear, earcon, level_db):
    assert hear(samples_of(earcon, level_db)) == []


def rms_of_loud(sound, above):
    return float(np.sqrt(np.mean(sound[np.abs(sound) > above] ** 2)))


def spoken_over(earcon, offset, snr_db):
    """ "stop" over an alarm, its begin `offset` [s] after that of the alarm."""
    word, alarm = say("stop").astype(float), samples_of(earcon, -6.0).astype(float)
    word *= SPEECH / rms_of_loud(word, 0.01)
    alarm *= SPEECH / rms_of_loud(alarm, 1e-3) * 10.0 ** (-snr_db / 20.0)
    first = round(offset * RATE)
    mixed = np.zeros(max(len(alarm), first + len(word)))
    mixed[: len(alarm)] += alarm
    mixed[first : first + len(word)] += word
    return mixed


@needs_espeak
@pytest.mark.parametrize("offset", [0.0, 0.2])
@pytest.mark.parametrize("earcon", [Earcon.STOP, Earcon.FAULT_HIGH, Earcon.FAULT_MEDIUM])
def test_stop_is_heard_over_an_alarm(hear, earcon, offset):
    assert "stop" in hear(spoken_over(earcon, offset, SNR))

# SPDX-License-Identifier: BSD-3-Clause
"""From synthetic speech to the call of a device, by the recogniser that is delivered."""

from dataclasses import replace

import numpy as np

from support.theatre_sound import LEVEL, speak, theatre_noise
from typed_config import load_config, load_yaml
from voice_assist.assembly import make_pipeline, make_recognizer
from voice_assist.audio.source import Framer
from voice_assist.config import CONFIG_DIR, CommandsConfig, load_voice_config
from voice_assist.config.devices import devices_config
from voice_assist.devices.calls import DeviceCalls
from voice_assist.types import RATE, Mode, UtteranceDecision, frozen_samples

SAID = ("light on", "higher pressure")
TALK = ("the light is on in there",)


class Clock:
    now = 0.0

    def __call__(self):
        return self.now


def called(words, mode):
    """Phrases whose calls follow from sentences, one after the other."""
    commands = load_config(CommandsConfig, load_yaml(CONFIG_DIR / "theatre_commands.yaml"))
    config = load_voice_config(spotter__is_enabled=False)
    config = replace(config, commands=commands)
    clock = Clock()
    pipeline = make_pipeline(config, clock, make_recognizer(config), None)
    pipeline.set_mode(mode, "test")
    pause = np.zeros(round(1.5 * RATE), np.float32)
    sound = np.concatenate([part for text in words for part in (pause, speak(text, "en-us", 150))])
    sound = np.concatenate([sound, pause])
    sound = sound + theatre_noise(len(sound) / RATE, 0.03 * LEVEL, seed=1)[: len(sound)]
    calls = DeviceCalls(devices_config(load_yaml(CONFIG_DIR / "devices.yaml")))
    made = []
    for frame in Framer().push(frozen_samples(sound.astype(np.float32)), 100.0):
        clock.now = frame.end
        for event in pipeline(frame):
            if isinstance(event, UtteranceDecision):
                calls.said(event.command)
                made += [call.phrase for call in iter(lambda: calls.next(0.0), None)]
    return made


def test_spoken_words_call_their_devices():
    assert called(SAID, Mode.ACTIVE) == list(SAID)


def test_talk_calls_none():
    assert called(TALK, Mode.ACTIVE) == []

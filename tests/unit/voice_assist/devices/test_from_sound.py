# SPDX-License-Identifier: BSD-3-Clause
"""From synthetic speech to the call of a device, by the recogniser that is delivered."""

from dataclasses import replace

import numpy as np

from support.theatre_sound import LEVEL, speak, theatre_noise
from tests.unit.voice_assist.support.fake_pipeline import StreamClock, decisions, run
from tests.unit.voice_assist.support.fake_speech import frames
from typed_config import load_config, load_yaml
from voice_assist.assembly import make_pipeline
from voice_assist.config import CONFIG_DIR, CommandsConfig, load_voice_config
from voice_assist.config.devices import devices_config
from voice_assist.devices.calls import DeviceCalls
from voice_assist.types import RATE, Mode

SAID = ("light on", "higher pressure")
TALK = ("the light is on in there",)


def test_spoken_words_call_their_devices_and_talk_calls_none(base):
    commands = load_config(CommandsConfig, load_yaml(CONFIG_DIR / "theatre_commands.yaml"))
    config = replace(load_voice_config(spotter__is_enabled=False), commands=commands)
    clock = StreamClock()
    pipeline = make_pipeline(config, clock, base)
    pipeline.set_mode(Mode.ACTIVE, "test")
    pause = np.zeros(round(1.5 * RATE), np.float32)
    said = (part for text in (*SAID, *TALK) for part in (pause, speak(text, "en-us", 150)))
    sound = np.concatenate([*said, pause])
    sound = sound + theatre_noise(len(sound) / RATE, 0.03 * LEVEL, seed=1)[: len(sound)]
    calls = DeviceCalls(devices_config(load_yaml(CONFIG_DIR / "devices.yaml")))
    decided = decisions(run(pipeline, clock, frames(sound.astype(np.float32))))
    for decision in decided:
        calls.said(decision.command)
    assert [call.phrase for call in iter(lambda: calls.next(0.0), None)] == list(SAID)

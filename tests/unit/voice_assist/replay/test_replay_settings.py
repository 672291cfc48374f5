# SPDX-License-Identifier: BSD-3-Clause
"""A replay restores recorded settings and models, and refuses what it cannot use."""

from dataclasses import is_dataclass
from typing import get_args, get_type_hints

import numpy as np
import pytest
import torch
import yaml

from tests.unit.voice_assist.support.fake_speech import FakeRecognizer
from tests.unit.voice_assist.support.replayed_pipeline import CONFIG, Block, FakeReplay
from typed_config import ConfigError, load_yaml
from voice_assist.config import CONFIG_DIR, SECTIONS, VoiceConfig
from voice_assist.replay import replayer as module
from voice_assist.replay.replayer import NotReplayable, replay_pipeline, restore_settings
from voice_assist.side_inputs import SideInputs


def settings():
    return {n: yaml.safe_load((CONFIG_DIR / f"{n}.yaml").read_text()) for n in SECTIONS}


@pytest.fixture
def given():
    """Recorded settings, for a test to change."""
    return settings()


def test_recorded_settings_are_active_but_for_the_device_and_a_model_that_is_given(given):
    given["audio"]["vad"]["hangover"] = 0.7
    given["recognizer"]["device"] = "cuda"
    config, warnings = restore_settings(given, None)
    assert config.audio.vad.hangover == 0.7 and config.recognizer.device == "cpu"
    assert warnings == ()
    assert restore_settings(given, "base.en")[0].recognizer.model == "base.en"


def test_settings_of_another_version_are_completed_and_said(given):
    del given["spotter"]["patience"]
    given["audio"]["vad"]["louder"] = True
    config, warnings = restore_settings(given, None)
    assert config.spotter.patience == CONFIG.spotter.patience
    assert [w.split(" ")[1] for w in warnings] == ["audio.vad.louder", "spotter.patience"]


def former_keys(kind, value):
    """Settings as a version before the present names recorded them."""
    if isinstance(value, list) and value and isinstance(value[0], dict):
        return [former_keys(get_args(kind)[0], entry) for entry in value]
    if not is_dataclass(kind):
        return value
    former = {now: then for then, now in getattr(kind, "RENAMED", {}).items()}
    hints = get_type_hints(kind)
    return {former.get(key, key): former_keys(hints[key], value[key]) for key in value}


def test_settings_recorded_under_their_former_names_are_restored():
    given = former_keys(VoiceConfig, settings())
    assert "talkback" in given["audio"] and "least_confidence" in given["commands"]["commands"][0]
    assert restore_settings(given, None) == (CONFIG, ())


def test_a_setting_that_is_gone_is_left_out_and_what_came_later_is_off(given):
    given["commands"]["commands"][0]["halt_score_threshold"] = 1000.0
    del given["moving"]["nearly_said"]
    config, warnings = restore_settings(given, None)
    assert config.commands == CONFIG.commands and config.moving.nearly_said == -1000.0
    assert warnings == ()


@pytest.mark.parametrize(("is_enabled", "taken_from"), [(False, 0.5), (True, 2.0)])
def test_a_recording_that_asked_by_its_former_limits_asks_within_them(
    given, is_enabled, taken_from
):
    given["recognizer"]["motion_verification"] = 0.5
    ask = given["recognizer"]["ask"] | {"is_enabled": is_enabled, "sure_verification": 2.0}
    del ask["min_verification"], ask["max_distance"]
    given["recognizer"]["ask"] = ask
    config, warnings = restore_settings(given, None)
    found = config.recognizer
    assert (found.ask.min_verification, found.motion_verification) == (0.5, taken_from)
    assert found.ask.max_distance == 0.0 and warnings == ()


def test_without_recorded_settings_those_of_today_are_used_and_said():
    config, warnings = restore_settings({}, None)
    assert config == CONFIG
    assert warnings == ("no settings were recorded; today's are used",)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("recognizer", "threads", 0), "threads is 0, allowed"),
        (("recognizer", "model", "no-such-model"), "no file no-such-model"),
        (("spotter", "phrase", "tense"), "spotter.phrase is 'tense'"),
    ],
)
def test_settings_and_notes_that_cannot_be_used_are_an_error(given, change, words):
    with pytest.raises(NotReplayable, match="is no side input"):
        replay_pipeline(given, ["nonsense"], None)
    section, key, value = change
    given[section][key] = value
    with pytest.raises(NotReplayable, match=words):
        replay_pipeline(given, [], None)


@pytest.mark.parametrize(("length", "rate"), [(511, 16_000), (512, 8_000), (0, 16_000)])
def test_a_block_that_is_no_frame_is_refused(length, rate):
    replayed = FakeReplay(CONFIG, FakeRecognizer(), None, SideInputs([]))
    with pytest.raises(NotReplayable, match=f"{length} samples at {rate} Hz, allowed: 512"):
        replayed.hear(Block(np.zeros(length, np.int16), rate, 0, 0.0))


def test_a_mode_can_be_taken_over_and_nonsense_not():
    replayed = FakeReplay(CONFIG, FakeRecognizer(), None, SideInputs([]))
    replayed.set_mode("active", "hey robot")
    assert replayed._pipeline.state.mode.value == "active"
    with pytest.raises(NotReplayable, match="allowed: standby, active"):
        replayed.set_mode("asleep", "")


@pytest.mark.parametrize(
    ("has_it", "recorded", "expected", "count"),
    [
        (True, "bfloat16", "bfloat16", 0),
        (False, "bfloat16", "auto", 1),
        (True, None, "float32", 0),  # from before there were precisions
    ],
)
def test_the_recorded_precision_is_kept_where_the_processor_has_it(
    given, monkeypatch, has_it, recorded, expected, count
):
    monkeypatch.setattr(torch.cpu, "_is_avx512_bf16_supported", lambda: has_it)
    given["recognizer"]["precision"] = recorded
    if recorded is None:
        del given["recognizer"]["precision"]
    config, warnings = restore_settings(given, None)
    assert config.recognizer.precision == expected
    assert len(warnings) == count
    assert all(warning.startswith("confidences may differ a little: ") for warning in warnings)


def test_where_the_settings_leave_the_precision_open_the_one_that_heard_is_kept(given, monkeypatch):
    monkeypatch.setattr(torch.cpu, "_is_avx512_bf16_supported", lambda: True)
    given["recognizer"]["precision"] = "auto"
    config, warnings = restore_settings({**given, "precision": "float32"}, None)
    assert config.recognizer.precision == "float32" and not warnings


def test_parameters_that_the_node_itself_sets_are_no_settings(given):
    own = {"opened_microphone": "pulse:headset", "has_talk_gate": True}
    assert restore_settings({**given, **own}, None)[1] == ()


def test_a_folder_of_recordings_loads_its_model_once(given, monkeypatch):
    loaded = []
    from voice_assist import recognizer

    def load(model, device, precision):
        loaded.append(model)
        return FakeRecognizer()

    monkeypatch.setattr(recognizer, "load_recognizer", load)
    module._english.cache_clear()
    given["spotter"]["is_enabled"] = False
    try:
        first, second = replay_pipeline(given, [], None), replay_pipeline(given, [], None)
    finally:
        module._english.cache_clear()
    assert loaded == ["embedded"] and first.model == second.model == "fake"


def test_a_session_in_another_language_is_replayed_by_what_heard_it(given, monkeypatch):
    made = []
    fake = FakeRecognizer()
    monkeypatch.setattr(module, "_of_another_language", lambda config: made.append(config) or fake)
    given["spotter"].update(is_enabled=False)
    given["commands"] = load_yaml(CONFIG_DIR / "commands_de.yaml")
    assert replay_pipeline(given, [], None).warnings == ()
    assert [(c.commands.language, c.commands.max_behind) for c in made] == [("de", 20.0)]


def test_what_a_recording_in_another_language_lacks_is_taken_from_the_file_of_that_language(given):
    given["commands"] = load_yaml(CONFIG_DIR / "commands_ja.yaml")
    del given["commands"]["max_behind"]
    config, warnings = restore_settings(given, None)
    assert config.commands.max_behind == 10.0
    assert warnings == ("setting commands.max_behind was not recorded; today's is 10.0",)


def test_a_recording_in_an_unknown_language_is_refused_with_those_there_are(given):
    given["commands"]["language"] = "it"
    with pytest.raises(ConfigError, match="'it', allowed: en, de, es, fr, ja"):
        restore_settings(given, None)


def test_a_recording_from_before_there_were_languages_is_english_and_said_once(given):
    for key in ("language", "said_twice"):
        del given["commands"][key]
    config, warnings = restore_settings(given, None)
    assert (config.commands.language, config.commands.said_twice, warnings) == ("en", False, ())

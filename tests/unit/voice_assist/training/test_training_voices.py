# SPDX-License-Identifier: BSD-3-Clause
"""Voices that training uses or leaves out, and what sounds like a command in some of them."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from voice_assist.errors import ModelError
from voice_assist.training import precision
from voice_assist.training.data import texts, voices
from voice_assist.training.data.homophones import same_as_command, sounds
from voice_assist.training.data.synthesis import (
    SynthesisAmounts,
    plan_held_out,
    plan_texts,
    plan_training,
)
from voice_assist.training.data.voices import Prompt, speak


@pytest.mark.parametrize("text", ["pool more", "pool less"])
def test_languages_with_one_such_vowel_make_pull_of_pool(text: str) -> None:
    assert same_as_command(text, "phonemes", "es+Mario")
    assert not same_as_command(text, "espeak", "en-us+Mario")
    assert not same_as_command(text, "rhvoice", "bdl")


@pytest.mark.parametrize("text", ["tents", "dense", "least", "full more", "shop", "terminal"])
@pytest.mark.parametrize("accent", ["en-us", "en-gb-scotland", voices.HELD_OUT_ACCENT])
def test_near_misses_that_can_be_distinguished_are_no_homophones(text: str, accent: str) -> None:
    assert not same_as_command(text, "espeak", f"{accent}+Mario")


@pytest.mark.parametrize("command", texts.COMMANDS)
def test_a_command_is_no_homophone_of_itself(command: str) -> None:
    assert not same_as_command(command, "espeak", "en-us+Mario")
    assert sounds(command, "espeak", "en-us+Mario")


def test_stress_does_not_make_a_difference() -> None:
    assert sounds("pull more", "flite", "rms") == sounds("pull, more", "flite", "rms")


def test_training_says_no_homophone_as_something_else() -> None:
    prompts = plan_training(texts.TALK, 3, SynthesisAmounts(0, 0, 80, 80, 0, 0, 0))
    assert {"phonemes", "rhvoice"} <= {prompt.engine for prompt in prompts}
    assert not [p for p in prompts if same_as_command(p.text, p.engine, p.voice)]


def test_training_leaves_whole_engines_and_voices_out() -> None:
    prompts = plan_training(texts.TALK, 1, SynthesisAmounts(600, 50, 50, 50, 50, 50, 50))
    assert not {"pico", "mbrola"} & {prompt.engine for prompt in prompts}
    spoken = {prompt.voice for prompt in prompts if prompt.engine == "rhvoice"}
    assert spoken <= set(voices.RHVOICE)
    assert not spoken & set(voices.HELD_OUT_RHVOICE)


def test_twins_are_near_misses_and_beginnings_are_none_of_them() -> None:
    near = {*texts.NEAR_MISSES, *texts.HARD}
    assert set(texts.TWINS) <= near
    assert not set(texts.BEGINNINGS) & {*near, *texts.COMMANDS}


@pytest.mark.parametrize(
    ("said", "amount"), [(texts.TWINS, 250), (texts.BEGINNINGS, 100), (texts.AMOUNTS, 100)]
)
def test_texts_are_said_by_voices_that_training_may_hear(
    said: tuple[str, ...], amount: int
) -> None:
    prompts = plan_texts(said, 1, amount)
    assert {prompt.text for prompt in prompts} <= set(said)
    assert not [p for p in prompts if same_as_command(p.text, p.engine, p.voice)]
    held_out = {prompt.voice for prompt in plan_held_out(1)}
    assert not held_out & {prompt.voice for prompt in prompts}


def test_a_missing_engine_is_named(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(ModelError, match="pico2wave"):
        speak([Prompt("stop", "pico", "en-GB", 1.0, 0.5)])
    with pytest.raises(ModelError, match="RHVoice-test"):
        speak([Prompt("stop", "rhvoice", "bdl", 1.0, 0.5)])


@pytest.mark.parametrize(
    ("program", "prompt"),
    [
        ("pico2wave", Prompt("pull more", "pico", "en-GB", 1.1, 0.4)),
        ("RHVoice-test", Prompt("pull more", "rhvoice", "bdl", 1.1, 0.4)),
        ("mbrola", Prompt("pull more", "mbrola", "mb-us1", 1.1, 0.4)),
    ],
)
def test_voices_of_other_sections_speak_where_they_are_installed(
    program: str, prompt: Prompt
) -> None:
    if shutil.which(program) is None:
        pytest.skip(f"{program} is not installed; only training and benches use it")
    (sound,) = speak([prompt])
    assert sound is not None
    assert 0.3 * 16000 < len(sound) < 2.0 * 16000
    assert np.abs(sound).max() == 16000


def test_numbers_are_cheap_only_where_the_processor_has_them(tmp_path: Path) -> None:
    old, new = tmp_path / "old", tmp_path / "new"
    old.write_text("flags\t\t: fpu avx avx2 fma\n", encoding="utf-8")
    new.write_text("flags\t\t: fpu avx2 avx512f avx512_bf16\n", encoding="utf-8")
    assert not precision.has_bfloat16(old)
    assert precision.has_bfloat16(new)
    assert not precision.has_bfloat16(tmp_path / "none")

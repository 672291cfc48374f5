# SPDX-License-Identifier: BSD-3-Clause
"""Voices that training uses or leaves out, and what sounds like a command in some of them."""

import shutil

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


def test_languages_with_one_such_vowel_make_pull_of_pool():
    for text in ("pool more", "pool less"):
        assert same_as_command(text, "phonemes", "es+Mario")
        assert not same_as_command(text, "espeak", "en-us+Mario")
        assert not same_as_command(text, "rhvoice", "bdl")


@pytest.mark.parametrize("text", ["tents", "dense", "least", "full more", "shop", "terminal"])
@pytest.mark.parametrize("accent", ["en-us", "en-gb-scotland", voices.HELD_OUT_ACCENT])
def test_near_misses_that_can_be_distinguished_are_no_homophones(text, accent):
    assert not same_as_command(text, "espeak", f"{accent}+Mario")


def test_a_command_is_no_homophone_of_itself_and_stress_makes_no_difference():
    for command in texts.COMMANDS:
        assert not same_as_command(command, "espeak", "en-us+Mario")
        assert sounds(command, "espeak", "en-us+Mario")
    assert sounds("pull more", "flite", "rms") == sounds("pull, more", "flite", "rms")


def test_training_says_no_homophone_as_something_else():
    prompts = plan_training(texts.TALK, 3, SynthesisAmounts(0, 0, 80, 80, 0, 0, 0))
    assert {"phonemes", "rhvoice"} <= {prompt.engine for prompt in prompts}
    assert not [p for p in prompts if same_as_command(p.text, p.engine, p.voice)]


def test_training_leaves_whole_engines_and_voices_out():
    prompts = plan_training(texts.TALK, 1, SynthesisAmounts(600, 50, 0, 0, 50, 50, 50))
    assert not {"pico", "mbrola"} & {prompt.engine for prompt in prompts}
    spoken = {prompt.voice for prompt in prompts if prompt.engine == "rhvoice"}
    assert spoken <= set(voices.RHVOICE)
    assert not spoken & set(voices.HELD_OUT_RHVOICE)


def test_twins_are_near_misses_and_beginnings_are_none_of_them():
    near = {*texts.NEAR_MISSES, *texts.HARD}
    assert set(texts.TWINS) <= near
    assert not set(texts.BEGINNINGS) & {*near, *texts.COMMANDS}


@pytest.mark.parametrize(
    ("said", "amount"), [(texts.TWINS, 250), (texts.BEGINNINGS, 100), (texts.AMOUNTS, 100)]
)
def test_texts_are_said_by_voices_that_training_may_hear(said, amount):
    prompts = plan_texts(said, 1, amount)
    assert {prompt.text for prompt in prompts} <= set(said)
    assert not [p for p in prompts if same_as_command(p.text, p.engine, p.voice)]
    held_out = {prompt.voice for prompt in plan_held_out(1)}
    assert not held_out & {prompt.voice for prompt in prompts}


HELD_OUT = [  # as the card's figures have them
    *("Alex", "AnxiousAndy", "Gene2", "Marco", "Nguyen", "Tweaky", "announcer", "boris", "edward"),
    *("f4", "gustave", "john", "klatt4", "m2", "m7", "miguel", "quincy", "robosoft3", "robosoft8"),
    *("steph3", "zac"),
]


def listing(names):
    """As espeak-ng lists variants."""
    lines = [f" 5  variant  --/M  {name}  !v/{name}  " for name in names]
    return "\n".join(["Pty Language", *lines]).encode()


def test_the_same_variants_are_held_out_whatever_else_espeak_speaks(monkeypatch):
    more = ["Bea", *HELD_OUT, "m1", "zoe"]
    monkeypatch.setattr(voices, "run_program", lambda _: listing(more))
    assert voices.espeak_variants() == (["Bea", "m1", "zoe"], HELD_OUT)
    monkeypatch.setattr(voices, "run_program", lambda _: listing(more[3:]))
    with pytest.raises(ModelError, match="lacks the held-out variants Alex, AnxiousAndy, allowed"):
        voices.espeak_variants()


def test_a_missing_engine_is_named(monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(ModelError, match="pico2wave"):
        speak([Prompt("stop", "pico", "en-GB", 1.0, 0.5)])
    with pytest.raises(ModelError, match="RHVoice-test"):
        speak([Prompt("stop", "rhvoice", "bdl", 1.0, 0.5)])


@pytest.mark.parametrize(
    ("program", "engine", "voice"),
    [
        ("pico2wave", "pico", "en-GB"),
        ("RHVoice-test", "rhvoice", "bdl"),
        ("mbrola", "mbrola", "mb-us1"),
    ],
)
def test_voices_of_other_sections_speak_where_they_are_installed(program, engine, voice):
    if shutil.which(program) is None:
        pytest.skip(f"{program} is not installed; only training and benches use it")
    (sound,) = speak([Prompt("pull more", engine, voice, 1.1, 0.4)])
    assert sound is not None
    assert 0.3 * 16000 < len(sound) < 2.0 * 16000
    assert np.abs(sound).max() == 16000


def test_numbers_are_cheap_only_where_the_processor_has_them(tmp_path):
    old, new = tmp_path / "old", tmp_path / "new"
    old.write_text("flags\t\t: fpu avx avx2 fma\n", encoding="utf-8")
    new.write_text("flags\t\t: fpu avx2 avx512f avx512_bf16\n", encoding="utf-8")
    assert not precision.has_bfloat16(old)
    assert precision.has_bfloat16(new)
    assert not precision.has_bfloat16(tmp_path / "none")

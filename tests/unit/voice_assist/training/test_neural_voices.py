# SPDX-License-Identifier: BSD-3-Clause
"""What Kokoro's voices are to say: accents in IPA, and no held-out voice among them."""

import shutil
from functools import cache

import pytest

from voice_assist.training.data import accents, neural_voices, texts
from voice_assist.training.data.accents import ACCENTS, english, for_kokoro
from voice_assist.training.data.kokoro import FOREIGN, NATIVE, SPEEDS
from voice_assist.training.data.neural_voices import folded, plan_foreign, plan_neural
from voice_assist.training.data.voices import espeak_variants

needs_espeak = pytest.mark.skipif(shutil.which("espeak-ng") is None, reason="needs espeak-ng")


@pytest.fixture(autouse=True, scope="module")
def pronounced_once():
    """The sounds of a text without an accent, which all accents begin with, are asked for once."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(accents, "ipa", cache(accents.ipa))
        yield


@needs_espeak
@pytest.mark.parametrize(
    ("text", "accent", "sounds"),
    [
        ("pull more", "", "pˈʊl mˈoɹ."),
        ("stop", "Spanish", "estˈop."),
        ("stop", "Japanese", "sɯtˈopɯ."),
        ("pull less", "Japanese", "pˈɯɾɯ ɾˈɛsɯ."),
        ("terminate", "Hindi", "ʈˈəɾmᵻnˌeʈ."),
        ("release", "German", "ʁᵻlˈis."),
        ("tense", "Italian", "tˈɛns."),
    ],
)
def test_sounds_of_a_command_in_an_accent(text, accent, sounds):
    assert english(text, british=False, accent=accent) == sounds


@needs_espeak
@pytest.mark.parametrize("accent", ACCENTS)
def test_no_accent_makes_two_commands_alike(accent):
    said = {english(text, british=False, accent=accent) for text in texts.COMMANDS}
    assert len(said) == len(texts.COMMANDS)


def test_a_change_of_language_within_a_word_is_no_sound():
    assert for_kokoro("(en)pˈʊl(fr) lˈɛs") == "pˈʊl lˈɛs."


@needs_espeak
def test_every_voice_says_every_command_and_no_twin_that_sounds_like_one(monkeypatch):
    monkeypatch.setattr(neural_voices, "ipa", lambda word, language: word)  # of other languages
    prompts = plan_neural(["the patient is stable today"])
    plain = {(p.voice, p.text, p.speed) for p in prompts if p.kind == "neural"}
    voices = (*NATIVE, *FOREIGN)
    assert plain == {(v, t, s) for v in voices for t in texts.COMMANDS for s in SPEEDS}
    near = {(p.sounds, p.voice) for p in prompts if "near" in p.kind}
    assert near.isdisjoint({(p.sounds, p.voice) for p in prompts if p.kind == "neural"})


@pytest.mark.parametrize(
    ("word", "letters"), [("pulmón", "pulmon"), ("teng2 se4", "teng se"), ("てんそ", "")]
)
def test_a_word_of_another_language_in_the_letters_of_the_recogniser(word, letters):
    assert folded(word) == letters


@needs_espeak
def test_no_held_out_variant_says_a_word_of_another_language():
    _, held_out = espeak_variants()
    assert {p.voice.partition("+")[2] for p in plan_foreign(1)}.isdisjoint(held_out)

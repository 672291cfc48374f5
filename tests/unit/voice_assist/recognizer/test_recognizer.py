# SPDX-License-Identifier: BSD-3-Clause
"""The recogniser: what the shipped checkpoint hears, and what it refuses to load."""

import shutil
import zipfile

import numpy as np
import pytest
import soxr
import torch
import whisper

from tests.unit.voice_assist.support.small_recognizer import whisper_file
from voice_assist.audio.espeak import espeak
from voice_assist.config import load_voice_config
from voice_assist.errors import CommandsError, ModelError
from voice_assist.recognizer import load_recognizer
from voice_assist.recognizer.checkpoint import EMBEDDED_PATH
from voice_assist.types import RATE

needs_espeak = pytest.mark.skipif(shutil.which("espeak-ng") is None, reason="needs espeak-ng")
COMMANDS = ("hey robot", "tense", "release", "pull more", "pull less", "stop", "terminate")


def test_a_phrase_is_scored_in_the_letters_of_the_vocabulary_or_refused_by_name(base):
    sound = say("light on")
    for phrase in ("x-ray on", "Preset 2", "tira más fuerte", "arrêtez"):
        scores = base.score(sound, [phrase, "light on"])
        assert set(scores) == {phrase, "light on"}
        assert scores["light on"] > 0.0 > scores[phrase]
    with pytest.raises(CommandsError, match="'とまれ', allowed: letters a to z"):
        base.score(sound, ["とまれ"])


def say(text, voice="en-us+john"):
    """Speech of a voice that training never heard, amid a little quiet."""
    samples, rate = espeak(text, voice, "-s", "160")
    sound = soxr.resample(samples.astype(np.float32) / 32768, rate, RATE)
    quiet = np.zeros(RATE // 5, np.float32)
    return np.concatenate([quiet, sound.astype(np.float32), quiet])


@needs_espeak
@pytest.mark.parametrize("text", COMMANDS)
def test_a_voice_never_trained_on_is_understood(base, text):
    sound = say(text)
    assert base.transcribe(sound).text == text
    if text in ("stop", "pull less"):  # the second opinion prefers it
        scores = base.score(sound, COMMANDS)
        assert max(scores, key=scores.__getitem__) == text
        assert sum(score > 0 for score in scores.values()) <= 1


@pytest.mark.parametrize("level", [0.0, 1e-4, 0.02, 0.2])
def test_nothing_is_heard_in_silence_and_noise(base, level):
    noise = np.random.default_rng(3).normal(0, 1, 2 * RATE).astype(np.float32) * level
    heard = base.transcribe(noise)
    assert heard.text not in COMMANDS
    assert level > 0.0 or (heard.text, heard.no_speech_prob) == ("", 1.0)


@pytest.mark.parametrize("seconds", [0.05, 0.1, 0.31, 10.0, 14.0])
def test_any_length_of_sound_is_accepted_and_not_changed(base, seconds):
    noise = np.random.default_rng(3).normal(0, 0.01, int(seconds * RATE)).astype(np.float32)
    before = noise.copy()
    noise.flags.writeable = False
    assert 0.0 <= base.transcribe(noise).confidence <= 1.0
    assert set(base.score(noise, ["stop"])) == {"stop"}
    np.testing.assert_array_equal(noise, before)


@needs_espeak
def test_a_text_that_loses_keeps_its_true_beginning(base):
    sound = say("the surgeon and the nurse had seen it yesterday")
    whole, asked = base.transcribe(sound).text, []

    def is_hopeless(beginning):
        asked.append(beginning)
        return len(beginning) > 6

    rough = base.transcribe(sound, is_hopeless)
    assert len(asked[-1]) > 6
    assert all(whole.startswith(beginning.strip()) for beginning in asked)
    assert rough.text.startswith(asked[-1].strip())
    assert 0.0 < rough.confidence <= 1.0


@needs_espeak
def test_scores_of_the_sound_just_heard_are_those_of_any_other(base):
    sound = say("pull less")
    fresh = base.score(sound, COMMANDS)
    sound.flags.writeable = False
    base.transcribe(sound)
    assert base.score(sound, COMMANDS) == fresh
    other = say("tense")
    base.transcribe(other)
    other[:] = sound[: len(other)] if len(sound) >= len(other) else np.resize(sound, len(other))
    assert base.score(other, COMMANDS)["tense"] < 0.0  # changed since: heard anew


@pytest.mark.parametrize(("doubt", "is_believed"), [(2.9, False), (1.5, True)])
def test_a_decoder_needs_the_ctc_head_to_believe_a_strange_word(
    base, monkeypatch, doubt, is_believed
):
    def opinion(liked):
        return lambda *given: torch.tensor([liked * (text == "tense") for text in given[-1]])

    monkeypatch.setattr("voice_assist.recognizer.embedded.decoder_likelihoods", opinion(4.4))
    monkeypatch.setattr("voice_assist.recognizer.embedded.ctc_likelihoods", opinion(-doubt))
    noise = np.random.default_rng(3).normal(0, 0.01, RATE).astype(np.float32)
    config = load_voice_config()
    score = base.score(noise, ["tense", "release"])["tense"]
    worth = config.recognizer.confidence.scores(score)
    assert (worth >= config.commands.get("tense").min_confidence) is is_believed


def test_the_whisper_library_loads_the_shipped_file():
    model = whisper.load_model(str(EMBEDDED_PATH), device="cpu")
    assert model.dims.n_vocab == 51864
    assert not model.is_multilingual


def test_a_hash_names_the_file_and_loading_leaves_the_thread_count_alone(base):
    before = torch.get_num_threads()
    assert len(base.model_hash) == 64
    assert base.model_hash == load_recognizer(str(EMBEDDED_PATH)).model_hash
    assert torch.get_num_threads() == before


def test_an_unknown_model_or_device_is_refused_with_what_is_allowed():
    for name in ("big.english", "~nobody-there/model.pt"):
        with pytest.raises(ModelError, match=rf"'{name}'.*embedded, multilingual, tiny\.en"):
            load_recognizer(name)
    with pytest.raises(ModelError, match="abacus"):
        load_recognizer(device="abacus")


def test_the_shipped_file_is_compressed_to_20_megabytes_at_most():
    assert EMBEDDED_PATH.stat().st_size <= 20e6
    with zipfile.ZipFile(EMBEDDED_PATH) as archive:
        assert all(entry.compress_type == zipfile.ZIP_DEFLATED for entry in archive.infolist())


def test_an_openai_model_is_decoded_without_padding(tmp_path):
    whisper_file(tmp_path / "small.pt")
    recognizer = load_recognizer(str(tmp_path / "small.pt"))
    noise = np.random.default_rng(3).normal(0, 0.01, RATE).astype(np.float32)
    assert 0.0 <= recognizer.transcribe(noise).confidence <= 1.0
    assert all(np.isfinite(list(recognizer.score(noise, ["stop", "tense"]).values())))

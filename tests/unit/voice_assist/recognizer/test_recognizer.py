# SPDX-License-Identifier: BSD-3-Clause
"""The recogniser: what the shipped checkpoint hears, and what it refuses to load."""

import shutil
import zipfile

import numpy as np
import pytest
import soxr
import torch
import whisper

from voice_assist.audio.espeak import espeak
from voice_assist.config import load_voice_config
from voice_assist.errors import CommandsError, ModelError
from voice_assist.recognizer import load_recognizer
from voice_assist.recognizer.checkpoint import EMBEDDED_PATH
from voice_assist.types import RATE

COMMANDS = ("hey robot", "tense", "release", "pull more", "pull less", "stop", "terminate")


@pytest.fixture(scope="module")
def embedded():
    return load_recognizer()


@pytest.mark.parametrize("phrase", ["x-ray on", "Preset 2", "tira más fuerte", "arrêtez"])
def test_a_phrase_is_scored_in_the_letters_of_the_vocabulary(embedded, phrase):
    sound = say("light on")
    scores = embedded.score(sound, [phrase, "light on"])
    assert set(scores) == {phrase, "light on"}
    assert scores["light on"] > 0.0 > scores[phrase]


def test_a_phrase_without_such_letters_is_refused_by_name(embedded):
    with pytest.raises(CommandsError, match="'とまれ', allowed: letters a to z"):
        embedded.score(say("light on"), ["とまれ"])


def say(text, voice="en-us+john"):
    """Speech of a voice that training never heard, amid a little quiet."""
    samples, rate = espeak(text, voice, "-s", "160")
    sound = soxr.resample(samples.astype(np.float32) / 32768, rate, RATE)
    quiet = np.zeros(RATE // 5, np.float32)
    return np.concatenate([quiet, sound.astype(np.float32), quiet])


@pytest.mark.skipif(shutil.which("espeak-ng") is None, reason="needs espeak-ng")
@pytest.mark.parametrize("text", COMMANDS)
def test_a_voice_never_trained_on_is_understood(embedded, text):
    assert embedded.transcribe(say(text)).text == text


@pytest.mark.skipif(shutil.which("espeak-ng") is None, reason="needs espeak-ng")
@pytest.mark.parametrize("text", ["stop", "pull less"])
def test_second_opinion_prefers_what_was_said(embedded, text):
    scores = embedded.score(say(text), COMMANDS)
    assert max(scores, key=scores.__getitem__) == text
    assert sum(score > 0 for score in scores.values()) <= 1


@pytest.mark.parametrize("level", [0.0, 1e-4, 0.02, 0.2])
def test_nothing_is_heard_in_silence_and_noise(embedded, level):
    noise = np.random.default_rng(3).normal(0, 1, 2 * RATE).astype(np.float32) * level
    assert embedded.transcribe(noise).text not in COMMANDS


def test_digital_silence_is_empty_text(embedded):
    heard = embedded.transcribe(np.zeros(RATE, np.float32))
    assert (heard.text, heard.no_speech_prob) == ("", 1.0)


@pytest.mark.parametrize("seconds", [0.05, 0.1, 0.31, 10.0, 14.0])
def test_any_length_of_sound_is_accepted(embedded, seconds):
    noise = np.random.default_rng(3).normal(0, 0.01, int(seconds * RATE)).astype(np.float32)
    assert 0.0 <= embedded.transcribe(noise).confidence <= 1.0
    assert set(embedded.score(noise, ["stop"])) == {"stop"}


def test_read_only_samples_are_not_changed(embedded):
    sound = np.random.default_rng(3).normal(0, 0.01, RATE).astype(np.float32)
    before = sound.copy()
    sound.flags.writeable = False
    embedded.transcribe(sound)
    np.testing.assert_array_equal(sound, before)


@pytest.mark.skipif(shutil.which("espeak-ng") is None, reason="needs espeak-ng")
def test_a_text_that_loses_keeps_its_true_beginning(embedded):
    sound = say("the surgeon and the nurse had seen it yesterday")
    whole, asked = embedded.transcribe(sound).text, []

    def is_hopeless(beginning):
        asked.append(beginning)
        return len(beginning) > 6

    rough = embedded.transcribe(sound, is_hopeless)
    assert len(asked[-1]) > 6
    assert all(whole.startswith(beginning.strip()) for beginning in asked)
    assert rough.text.startswith(asked[-1].strip())
    assert 0.0 < rough.confidence <= 1.0


@pytest.mark.skipif(shutil.which("espeak-ng") is None, reason="needs espeak-ng")
def test_scores_of_the_sound_just_heard_are_those_of_any_other(embedded):
    sound = say("pull less")
    fresh = embedded.score(sound, COMMANDS)
    sound.flags.writeable = False
    embedded.transcribe(sound)
    assert embedded.score(sound, COMMANDS) == fresh
    other = say("tense")
    embedded.transcribe(other)
    other[:] = sound[: len(other)] if len(sound) >= len(other) else np.resize(sound, len(other))
    assert embedded.score(other, COMMANDS)["tense"] < 0.0  # changed since: heard anew


@pytest.mark.parametrize(("doubt", "is_believed"), [(2.9, False), (1.5, True)])
def test_a_decoder_needs_the_ctc_head_to_believe_a_strange_word(
    embedded, monkeypatch, doubt, is_believed
):
    def opinion(liked):
        return lambda _model, *rest: torch.tensor(
            [liked if t == "tense" else 0.0 for t in rest[-1]]
        )

    monkeypatch.setattr("voice_assist.recognizer.embedded.decoder_likelihoods", opinion(4.4))
    monkeypatch.setattr("voice_assist.recognizer.embedded.ctc_likelihoods", opinion(-doubt))
    noise = np.random.default_rng(3).normal(0, 0.01, RATE).astype(np.float32)
    config = load_voice_config()
    score = embedded.score(noise, ["tense", "release"])["tense"]
    worth = config.recognizer.confidence.scores(score)
    assert (worth >= config.commands.get("tense").min_confidence) is is_believed


def test_the_whisper_library_loads_the_shipped_file():
    model = whisper.load_model(str(EMBEDDED_PATH), device="cpu")
    assert model.dims.n_vocab == 51864
    assert not model.is_multilingual


def test_the_shipped_file_is_at_most_20_megabytes():
    assert EMBEDDED_PATH.stat().st_size <= 20e6


def test_hash_names_the_file(embedded):
    assert len(embedded.model_hash) == 64
    assert embedded.model_hash == load_recognizer(str(EMBEDDED_PATH)).model_hash


def test_loading_leaves_the_thread_count_alone():
    before = torch.get_num_threads()
    load_recognizer()
    assert torch.get_num_threads() == before


@pytest.mark.parametrize("name", ["big.english", "~nobody-there/model.pt"])
def test_an_unknown_model_is_refused_with_what_is_allowed(name):
    with pytest.raises(ModelError, match=rf"'{name}'.*embedded, multilingual, tiny\.en"):
        load_recognizer(name)


def test_an_unknown_device_is_refused():
    with pytest.raises(ModelError, match="abacus"):
        load_recognizer(device="abacus")


def test_the_shipped_file_is_compressed():
    with zipfile.ZipFile(EMBEDDED_PATH) as archive:
        assert all(entry.compress_type == zipfile.ZIP_DEFLATED for entry in archive.infolist())


def test_an_openai_model_is_decoded_without_padding(tmp_path):
    torch.manual_seed(0)
    dims = whisper.model.ModelDimensions(80, 1500, 64, 2, 1, 51864, 448, 64, 2, 1)
    model = whisper.model.Whisper(dims)
    torch.nn.init.normal_(model.decoder.positional_embedding)
    path = tmp_path / "small.pt"
    torch.save({"dims": vars(dims), "model_state_dict": model.state_dict()}, path)
    recognizer = load_recognizer(str(path))
    noise = np.random.default_rng(3).normal(0, 0.01, RATE).astype(np.float32)
    assert 0.0 <= recognizer.transcribe(noise).confidence <= 1.0
    assert all(np.isfinite(list(recognizer.score(noise, ["stop", "tense"]).values())))

# SPDX-License-Identifier: BSD-3-Clause
"""What training keeps is found again only where it was made of the same."""

import subprocess
import sys
import wave
from types import SimpleNamespace
from unittest.mock import Mock

import numpy as np
import pytest

from tests.unit.voice_assist.support.records import SPEECH_HEAD
from voice_assist.config import load_voice_config
from voice_assist.training.array_file import write_arrays
from voice_assist.training.cache_key import digest
from voice_assist.training.data import align
from voice_assist.training.data.human import load_speech, read_manifest
from voice_assist.training.data.synthesis import TrainingClip
from voice_assist.training.spotter import dataset, trials
from voice_assist.training.spotter.dataset import SpotterAmounts
from voice_assist.training.verifier import train_verifier


def write_wav(path, level):
    with wave.open(str(path), "wb") as file:
        file.setnchannels(1)
        file.setsampwidth(2)
        file.setframerate(16000)
        file.writeframes(np.full(1600, level, np.int16).tobytes())


def write_manifest(folder, **splits):
    lines = [f"{name}.wav,speech,{name},{name},0.1,CC0,x,{splits[name]}\n" for name in splits]
    (folder / "manifest.csv").write_text(SPEECH_HEAD + "".join(lines))
    return read_manifest(folder)


@pytest.fixture
def speech(tmp_path):
    """Two people, each with a sound of another level."""
    folder = tmp_path / "speech"
    folder.mkdir()
    for name, level in (("anna", 1000), ("bert", 2000)):
        write_wav(folder / f"{name}.wav", level)
    return folder


def heard(rows, cache):
    clips = load_speech(rows, "train", cache)
    return {clip.text: round(float(clip.samples.mean()), -1) for clip in clips}


def test_a_person_is_trained_on_by_the_newest_split_and_recording(speech, tmp_path):
    before = write_manifest(speech, anna="train", bert="dev")
    assert heard(before, tmp_path / "cache") == {"anna": 1000}
    after = write_manifest(speech, anna="dev", bert="train")
    assert heard(after, tmp_path / "cache") == {"bert": 2000}
    write_wav(speech / "bert.wav", 3000)
    assert heard(after, tmp_path / "cache") == {"bert": 3000}


def test_embeddings_of_other_recordings_are_computed_anew(speech, tmp_path, monkeypatch):
    computed = []

    def compute(_, path):
        computed.append(path)
        write_arrays(path, embeddings=np.zeros((1, 96)), labels=np.zeros(1), begins=np.zeros(1))

    monkeypatch.setattr(dataset, "_compute", compute)
    monkeypatch.setattr(dataset, "load_material", lambda *_: None)
    monkeypatch.setattr(dataset, "training_rows", lambda speech, _: read_manifest(speech))
    for splits in ({"anna": "train", "bert": "dev"}, {"anna": "dev", "bert": "train"}):
        write_manifest(speech, **splits)
        for _ in range(2):
            dataset.load_steps(speech, tmp_path / "cache", 1, SpotterAmounts())
    assert len(computed) == len(set(computed)) == 2 * 4


def test_the_verifier_learns_from_voices_that_were_installed_since(tmp_path, monkeypatch):
    saved, neural = [], []

    def save(_, path):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(b"")
        saved.append(path)

    sound = np.arange(9, dtype=np.int16)
    checkpoint = SimpleNamespace(sha256="0" * 64)
    model = SimpleNamespace(eval=lambda: None)
    fakes = {
        "read_checkpoint": lambda _: checkpoint,
        "restore": lambda _: model,
        "write_verifier": lambda *_: None,
        "_espeak": lambda _: [(sound, "release", "espeak:a")],
        "_people": lambda *_: [],
        "_kokoro": lambda *_: neural,
        "_seen": lambda *_: [],
    }
    for name, fake in fakes.items():
        monkeypatch.setattr(train_verifier, name, fake)
    monkeypatch.setattr(train_verifier.examples, "save", save)
    monkeypatch.setattr(train_verifier.examples, "load", lambda _: {})
    (tmp_path / "manifest.csv").write_text(SPEECH_HEAD)
    places = "--speech", tmp_path, "--cache", tmp_path, "--out", tmp_path / "v.pt"
    options = train_verifier.parse(list(map(str, places)))
    for installed, so_far in (([], 1), ([], 1), ([(sound, "release", "kokoro:b")], 2)):
        neural += installed
        train_verifier._run(options)
        assert len(saved) == so_far


def test_word_times_belong_to_their_clips_and_not_to_their_places(tmp_path, monkeypatch):
    monkeypatch.setattr(align, "_times", lambda _, clip: clip.samples[:2] / 10)
    one, other = (
        TrainingClip(np.full(900, level, np.int16), "up", "word", "x") for level in (10, 20)
    )
    for clips, begins in (((one, other), [0.92, 1.92]), ((other, one), [1.92, 0.92])):
        found = align.align_clips(None, clips, tmp_path / "word_times_1.npz")
        assert [aligned.words[0].start for aligned in found] == pytest.approx(begins)


@pytest.fixture
def runner(tmp_path, monkeypatch):
    """Makes a runner of trials that only counts what it runs."""
    ran = []
    fakes = {
        "make_spotter": lambda _: (None, "digest"),
        "make_detector": lambda _: None,
        "Pipeline": lambda *_: None,
        "read_head": lambda: (None, "digest"),
        "LongEmbedder": lambda: None,
    }
    for name, fake in fakes.items():
        monkeypatch.setattr(trials, name, fake)
    monkeypatch.setattr(trials.TrialRunner, "_run", lambda *given: ran.append(given) or [])
    recognizer = SimpleNamespace(model_hash="hash")

    def make(**settings):
        config = load_voice_config(**settings)
        return trials.TrialRunner(config, recognizer, tmp_path / "tune", -2.0)

    make.ran = ran
    return make


def test_trials_of_other_clips_noises_or_settings_are_run_anew(runner, tmp_path):
    run, said, noise = runner(), [("a", np.ones(5, np.float32))], np.ones(9, np.float32)
    other = [("a", np.zeros(5, np.float32))]
    for given in ((said,), (other,), (said, [noise], 10.0), (said, [2 * noise], 10.0)):
        for _ in range(2):
            run("human", *given)
    assert len(runner.ran) == 4
    runner(spotter__alone=7.0, spotter__near=2.0)("human", said)  # what is tuned
    assert len(runner.ran) == 4
    runner(audio__vad__hangover=0.61)("human", said)
    assert len(runner.ran) == 5
    assert {path.suffix for path in (tmp_path / "tune").iterdir()} == {".json"}


def test_trials_that_are_not_written_whole_are_run_again(runner, tmp_path, monkeypatch):
    run, said = runner(), [("a", np.ones(5, np.float32))]
    crash = Mock(side_effect=OSError("no space"))
    with monkeypatch.context() as patch, pytest.raises(OSError, match="no space"):
        patch.setattr("pathlib.Path.replace", crash)
        run("human", said)
    assert not list((tmp_path / "tune").iterdir())
    run("human", said)
    assert len(runner.ran) == 2


def test_a_key_is_the_same_in_every_process_and_tells_arrays_apart():
    words = frozenset("abcdef")
    code = "from voice_assist.training.cache_key import digest; print(digest(frozenset('abcdef')))"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == digest(words)
    flat = np.zeros(4, np.int16)
    kinds = [flat, flat.reshape(2, 2), flat.astype(np.int32), [flat], [flat[:2], flat[2:]]]
    assert len({digest(kind) for kind in kinds}) == len(kinds)

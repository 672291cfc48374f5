# SPDX-License-Identifier: BSD-3-Clause
"""Faults that others met between sound and command; `README.md` here lists the tests of all."""

import ast
import itertools
import shutil
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import torch
import whisper

from tests.unit.voice_assist.recognizer.test_recognizer import COMMANDS
from tests.unit.voice_assist.recognizer.test_recognizer import say as espeak
from tests.unit.voice_assist.support.fake_pipeline import StreamClock, commands, run
from tests.unit.voice_assist.support.fake_speech import (
    FakeRecognizer,
    frames,
    make_detector,
    say,
    silence,
)
from tests.unit.voice_assist.support.records import command_entries
from voice_assist.config import CONFIG_DIR, load_voice_config
from voice_assist.intent.mapper import Mapper
from voice_assist.pipeline.pipeline import Pipeline
from voice_assist.recognizer import load_recognizer
from voice_assist.recognizer.recognizer import NO_SPEECH_THRESHOLD
from voice_assist.recognizer.vocabulary import PROMPT
from voice_assist.text.normalize import normalize
from voice_assist.types import RATE, Match, Mode, NoMatch, never_hopeless
from voice_assist.vad.detector import make_detector as real_detector

needs_espeak = pytest.mark.skipif(shutil.which("espeak-ng") is None, reason="needs espeak-ng")
SECONDS = 1.6


@pytest.fixture(scope="module", autouse=True)
def one_thread():
    """As the node runs; more threads only get in each other's way on a busy machine."""
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(before)


@pytest.fixture(scope="module")
def embedded():
    return load_recognizer()


@pytest.fixture(scope="module")
def silero():
    return real_detector(load_voice_config().audio.vad)


def time_axis(seconds=SECONDS):
    return np.arange(round(seconds * RATE)) / RATE


def hiss(level, seconds=SECONDS):
    return level * np.random.default_rng(7).standard_normal(round(seconds * RATE))


def hum():
    """Mains: 50 Hz and its overtones."""
    t = time_axis()
    return sum(0.1 / k * np.sin(2 * np.pi * 50 * k * t) for k in range(1, 8))


def fan():
    """Broad noise, swept by a blade 23 times a second, over the tone of its motor."""
    t = time_axis()
    return hiss(0.05) * (1 + 0.3 * np.sin(2 * np.pi * 23 * t)) + 0.02 * np.sin(2 * np.pi * 276 * t)


def robot_in_motion():
    """Gears and motors: a whine that rises and falls with the joints' speed, and grinding."""
    t = time_axis()
    speed = np.abs(np.sin(2 * np.pi * 0.4 * t))
    phase = 2 * np.pi * np.cumsum(250 + 900 * speed) / RATE
    whine = sum(0.08 / k * np.sin(k * phase) for k in (1, 2, 3, 5))
    return speed * (whine + hiss(0.03)) + hiss(0.002)


def heard_commands(sound, recognizer, detector):
    """What the pipeline as shipped, but active so that all commands count, makes of a sound."""
    clock = StreamClock()
    pipeline = Pipeline(load_voice_config(), recognizer, detector, clock)
    pipeline.reset()
    pipeline.set_mode(Mode.ACTIVE, "test")
    return commands(run(pipeline, clock, frames(np.asarray(sound, np.float32))))


@needs_espeak
@pytest.mark.parametrize(
    ("said", "other"), [("pull more", "pull less"), ("pull less", "pull more")]
)
def test_pull_more_and_pull_less_do_not_score_alike(embedded, said, other):
    """Scoring a phrase by its first token alone gives all that begin with "pull" one score."""
    scores = embedded.score(espeak(said), COMMANDS)
    assert scores[said] > scores[other] + 5.0


def test_two_phrases_of_one_first_word_differ_in_any_sound(embedded):
    """The whole sequence is scored: phrases that only end differently differ in noise as well."""
    scores = embedded.score(hiss(0.05, 1.0).astype(np.float32), ["pull more", "pull less", "pull"])
    assert len({round(score, 3) for score in scores.values()}) == 3


@pytest.mark.parametrize("sound", [hum, fan, lambda: hiss(0.0), lambda: hiss(1e-3)])
def test_without_speech_there_is_no_command(embedded, silero, sound):
    """A prompt or hot words make a recogniser write commands into silence and noise."""
    assert heard_commands(sound(), embedded, silero) == []
    assert embedded.transcribe(sound()[:RATE].astype(np.float32)).text not in COMMANDS


def test_the_recogniser_is_primed_with_no_words(embedded, tmp_path):
    """A decoder tends to write the words of its prompt: this prompt only begins the text."""
    tokenizer = whisper.tokenizer.get_tokenizer(multilingual=False)
    assert len(PROMPT) == 2  # begin, no time stamps
    options = openai_recognizer(tmp_path)._task.options
    assert options.prompt is None and options.prefix is None
    sequence = tokenizer.sot_sequence_including_notimestamps
    assert all(token >= tokenizer.eot for token in sequence)


def openai_recognizer(folder):
    """A tiny Whisper with OpenAI's vocabulary and random weights."""
    torch.manual_seed(0)
    dims = whisper.model.ModelDimensions(80, 1500, 64, 2, 1, 51864, 448, 64, 2, 1)
    path = folder / "small.pt"
    state = whisper.model.Whisper(dims).state_dict()
    torch.nn.init.normal_(state["decoder.positional_embedding"])  # Whisper leaves it unset
    torch.save({"dims": vars(dims), "model_state_dict": state}, path)
    return load_recognizer(str(path))


@pytest.mark.parametrize(
    ("no_speech", "text"), [(0.95, ""), (NO_SPEECH_THRESHOLD, ""), (0.1, "stop"), (0.001, "stop")]
)
def test_words_without_speech_are_none_however_sure_they_are(tmp_path, no_speech, text):
    """Whisper overlooks its own doubt that anybody spoke where the words themselves are likely."""
    recognizer = openai_recognizer(tmp_path)
    made_up = SimpleNamespace(text="stop", avg_logprob=-0.01, no_speech_prob=no_speech)
    recognizer._task = SimpleNamespace(run=lambda states: [made_up], decoder=SimpleNamespace())
    heard = recognizer.transcribe(hiss(0.05, 1.0).astype(np.float32))
    assert (heard.text, heard.no_speech_prob) == (text, no_speech)


def with_listening():
    """The shipped commands, and two that differ by one word and mean the opposite."""
    shipped = command_entries()
    model = next(c for c in shipped if c["phrase"] == "tense")
    both = [{**model, "phrase": f"{verb} listening"} for verb in ("start", "stop")]
    return load_voice_config(commands__commands=[*shipped, *both]).commands


def test_stop_listening_is_not_start_listening():
    """By edit distance of letters "stop listening" was taken for "start listening"."""
    mapper = Mapper(with_listening())
    for verb, other in (("start", "stop"), ("stop", "start")):
        outcome = mapper(f"{verb} listening")
        assert isinstance(outcome, Match) and outcome.command == f"{verb} listening"
        assert outcome.wer[f"{other} listening"] == 0.5


@pytest.mark.parametrize("words", ["stock listening", "store listening", "stop glistening"])
def test_a_word_between_two_commands_is_neither(words):
    """What lies near two commands of opposite meaning is taken for neither."""
    assert isinstance(Mapper(with_listening())(words), NoMatch)


def test_one_other_word_never_makes_a_motion():
    """Of a short command one word is half its meaning: with any other word it is no command."""
    config = load_voice_config().commands
    mapper = Mapper(config)
    motions = [c for c in config.commands if not c.is_halt]
    tried = 0
    for command, other in itertools.product(motions, ("start", "listening", "less", "more", "row")):
        words = normalize(command.phrase)
        for place in range(len(words)):
            changed = " ".join((*words[:place], other, *words[place + 1 :]))
            outcome = mapper(changed)
            taken = outcome.command if isinstance(outcome, Match) else changed
            assert taken == changed, (changed, taken)
            tried += 1
    assert tried == 45


def test_zeros_at_the_start_of_a_headset_neither_trigger_nor_deafen():
    """Bluetooth sends 0.6 s of zeros first; a noise floor learnt from them is far too low."""
    start = np.zeros(round(0.6 * RATE), np.float32)
    fake = FakeRecognizer()
    room = np.r_[start, hiss(0.003).astype(np.float32)]
    assert heard_commands(room, fake, make_detector()) == []
    words = say("hey robot", before=0.0)
    spoken = np.r_[start, words + hiss(1e-4, len(words) / RATE)]
    assert heard_commands(spoken, fake, make_detector()) == ["hey robot"]


@needs_espeak
def test_after_zeros_the_shipped_networks_hear_the_first_word(embedded, silero):
    """The same with the detector and the recogniser that are shipped."""
    sound = np.r_[np.zeros(round(0.6 * RATE)), espeak("stop"), silence(0.7)]
    assert heard_commands(sound, embedded, silero) == ["stop"]


def test_the_noise_of_the_moving_robot_is_no_command(embedded, silero):
    """Gears and motors were taken for words by others' recognisers."""
    assert heard_commands(robot_in_motion(), embedded, silero) == []


@needs_espeak
def test_stop_is_heard_over_the_moving_robot(embedded, silero):
    """Nor may that noise hide the one word that must get through."""
    word = espeak("stop")
    sound = 0.3 * np.tile(robot_in_motion(), 2)
    sound[RATE : RATE + len(word)] += word
    assert heard_commands(sound, embedded, silero) == ["stop"]


def test_the_product_has_no_voice_to_hear_itself_by():
    """Robots heard their own announcements as commands: here no module opens a way out."""
    files = list((CONFIG_DIR.parent / "src").rglob("*.py"))
    assert len(files) > 30
    ways_out = {"OutputStream", "RawOutputStream", "Stream", "RawStream", "play", "playrec"}
    for file in files:
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
                is_sound = node.value.id in ("sd", "sounddevice")
                assert not (is_sound and node.attr in ways_out), file


class Listener(FakeRecognizer):
    """Keeps what it was given."""

    def __init__(self):
        super().__init__()
        self.sounds = []

    def transcribe(self, samples, is_hopeless=never_hopeless):
        self.sounds.append(np.array(samples))
        return super().transcribe(samples, is_hopeless)


@pytest.mark.parametrize(
    ("mode", "is_raw"), [(None, True), ("endpointing_only", True), ("off", True), ("on", False)]
)
def test_the_recogniser_hears_the_sound_as_it_is_unless_set_otherwise(mode, is_raw):
    """Noise reduction before a recogniser often raises its error rate; by default there is none."""
    config = load_voice_config()
    if mode is None:
        assert config.audio.denoise.mode == "endpointing_only"
    else:
        denoise = replace(config.audio.denoise, mode=mode)
        config = replace(config, audio=replace(config.audio, denoise=denoise))
    listener, clock = Listener(), StreamClock()
    pipeline = Pipeline(config, listener, make_detector(), clock)
    words = say("pull more")
    stream = frames((words + hiss(0.004, len(words) / RATE)).astype(np.float32))
    run(pipeline, clock, stream)
    sound = np.concatenate([frame.samples for frame in stream])
    given = max(listener.sounds, key=len)
    given = given[: np.flatnonzero(given)[-1] + 1]  # silence is put behind a settled transcript
    windows = np.lib.stride_tricks.sliding_window_view(sound, 64)
    begins = np.flatnonzero((windows == given[:64]).all(axis=1))
    same = [s for s in begins if np.array_equal(sound[s : s + len(given)], given)]
    assert bool(same) is is_raw

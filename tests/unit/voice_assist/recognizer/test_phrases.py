# SPDX-License-Identifier: BSD-3-Clause
"""Phrases of another language by their normed likelihood: with given numbers, and with Whisper."""

from dataclasses import replace
from functools import cache
from itertools import product

import numpy as np
import pytest

from voice_assist.assembly import make_recognizer
from voice_assist.config import load_voice_config
from voice_assist.config.commands import LANGUAGES
from voice_assist.errors import CommandsError, ModelError
from voice_assist.recognizer import whisper
from voice_assist.recognizer.checkpoint import FETCH, multilingual_path
from voice_assist.recognizer.phrases import APART, BEHIND, LEAST, LEAST_OF_MOTION, PhraseRecognizer
from voice_assist.text.phonetic_distance import espeak_language
from voice_assist.training.data.voices import Prompt, speak
from voice_assist.training.phrase_background import sounds_of
from voice_assist.types import RATE, Hypothesis, frozen_samples

GERMAN = load_voice_config(language="de").commands
SOUND = frozen_samples(np.full(RATE, 0.1, np.float32))
has_model = pytest.mark.skipif(not multilingual_path().is_file(), reason=FETCH)
HELD_OUT = ("f4", "m7")  # variants of espeak-ng that no background was measured in


class Heard:
    """Stands for Whisper: each phrase so many spreads above its background."""

    name, model_hash = "heard", "none"

    def __init__(self, written="", behind=0.0, **spreads):
        self._written, self._behind, self.asked = written, behind, 0
        self._spreads = {name.replace("_", " "): z for name, z in spreads.items()}

    def transcribe(self, samples, is_hopeless=None):
        return Hypothesis(self._written, -0.1, 0.0)

    def likelihoods(self, samples, texts):
        self.asked += 1
        found = {}
        for command in GERMAN.commands:
            mean, spread = command.background
            found[command.phrase] = mean + spread * self._spreads.get(command.phrase, -1.0)
        if "" in texts:
            (phrase,) = (p for p in texts if p)
            found[""] = found[phrase] + self._behind
        return {phrase: found[phrase] for phrase in texts}


def hears(**said):
    return PhraseRecognizer(Heard(**said), GERMAN)


def test_a_phrase_far_above_its_background_and_the_others_is_written():
    heard = hears(mehr_ziehen=LEAST_OF_MOTION + 2.0, stop=LEAST).transcribe(SOUND)
    assert heard.text == "mehr ziehen"
    assert 0.9 < heard.confidence < 1.0
    just = hears(mehr_ziehen=LEAST_OF_MOTION + 0.01).transcribe(SOUND)
    assert 0.79 < just.confidence < heard.confidence


@pytest.mark.parametrize(
    "said",
    [
        {"mehr_ziehen": LEAST_OF_MOTION - 0.1},
        {"mehr_ziehen": LEAST_OF_MOTION + 2.0, "weniger_ziehen": LEAST_OF_MOTION + 2.1 - APART},
        {"mehr_ziehen": LEAST_OF_MOTION + 2.0, "behind": BEHIND + 0.1},
    ],
)
def test_what_is_no_phrase_surely_is_what_the_model_writes(said):
    assert hears(written="etwas anderes", **said).transcribe(SOUND).text == "etwas anderes"


def test_a_language_may_want_its_motions_nearer_to_what_the_model_writes():
    strict = replace(GERMAN, max_behind=5.0)

    def taken(**said):
        return PhraseRecognizer(Heard(written="anderes", **said), strict).transcribe(SOUND).text

    sure = LEAST_OF_MOTION + 2.0
    assert taken(mehr_ziehen=sure, behind=5.1) == "anderes"
    assert taken(mehr_ziehen=sure, behind=4.9) == "mehr ziehen"
    assert taken(hallo_roboter=sure, behind=5.1) == "hallo roboter"


def test_a_text_that_denies_is_no_motion_but_may_be_a_stop():
    denied = "nicht mehr ziehen"
    assert hears(written=denied, mehr_ziehen=9.0).transcribe(SOUND).text == denied
    assert hears(written="kein Halt", halt=9.0).transcribe(SOUND).text == "halt"


def test_two_words_for_a_stop_do_not_stand_in_each_others_way():
    assert hears(halt=LEAST + 1.0, stop=LEAST + 0.9).transcribe(SOUND).text == "halt"


def device(phrase, **changes):
    """A phrase that calls nothing of the robot."""
    wakes = next(c for c in GERMAN.commands if c.command == "hey robot")
    plain = {"spellings": (), "command": "", "modes": ("active",), **changes}
    return replace(wakes, phrase=phrase, **plain)


def test_two_phrases_of_devices_are_kept_apart():
    on, off = "licht einschalten", "licht ausschalten"
    commands = replace(GERMAN, commands=(*GERMAN.commands, device(on), device(off)))
    recognizer = PhraseRecognizer(Heard(), commands)
    norms = dict.fromkeys(commands.phrases, -1.0) | {on: LEAST + 1.0, off: LEAST + 1.0}
    assert recognizer._margin(norms, on) == -APART


def test_where_no_phrase_calls_the_robot_two_words_for_a_stop_are_one():
    halts = tuple(replace(c, command="") for c in GERMAN.commands if c.is_halt)
    wakes = device("hallo", modes=("standby",), mode_after="active")
    recognizer = PhraseRecognizer(Heard(), replace(GERMAN, commands=(*halts, wakes)))
    assert recognizer._margin({"halt": 3.0, "stop": 3.0, "hallo": 0.0}, "halt") == 3.0 - LEAST
    assert recognizer._margin({"halt": 3.0, "stop": 3.0}, "halt") == 3.0 - LEAST  # no others


def test_a_score_is_above_0_for_what_is_surely_said_and_below_for_all_else():
    recognizer = hears(mehr_ziehen=LEAST_OF_MOTION + 3.0)
    scores = recognizer.score(SOUND, GERMAN.phrases)
    assert scores["mehr ziehen"] == pytest.approx(3.0)
    assert max(z for phrase, z in scores.items() if phrase != "mehr ziehen") < 0.0
    recognizer.score(SOUND, GERMAN.phrases)
    assert recognizer._base.asked == 1  # a sound is heard once


def test_silence_is_nothing():
    silence = frozen_samples(np.zeros(RATE))
    assert hears(halt=9.0).transcribe(silence).text == ""
    assert set(hears(halt=9.0).score(silence, ["halt"]).values()) == {float("-inf")}


def test_a_phrase_without_background_is_refused_with_what_measures_it():
    commands = (replace(GERMAN.commands[0], background=()), *GERMAN.commands[1:])
    with pytest.raises(CommandsError, match=r"commands\[0\].background.*phrase_background"):
        replace(GERMAN, commands=commands)
    with pytest.raises(CommandsError, match="median and spread"):
        replace(GERMAN.commands[0], background=(-30.0, 0.0))


def test_the_embedded_model_refuses_another_language():
    with pytest.raises(ModelError, match=r"hears English only, not 'fr'.*make languages"):
        whisper.load_multilingual("embedded", "cpu", "fr")


def test_backgrounds_are_measured_in_training_voices():
    said = dict(sounds_of(GERMAN, voices=1))
    assert set(said) == set(GERMAN.phrases)
    assert all(len(sound) > RATE / 2 for sound in said.values())


@pytest.fixture(scope="module")
def weights():
    """Those of Whisper, read once for all languages."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(whisper, "_checkpoint", cache(whisper._checkpoint))
        yield


@has_model
@pytest.mark.usefixtures("weights")
@pytest.mark.parametrize("language", LANGUAGES[1:])
def test_whisper_base_hears_held_out_voices_and_takes_no_phrase_for_another(language):
    config = load_voice_config(language=language)
    recognizer, commands = make_recognizer(config), config.commands.commands
    called, right = {command.phrase: command.command for command in commands}, 0
    for command, name in product(commands, HELD_OUT):
        voice = f"{espeak_language(language)}+{name}"
        (sound,) = speak([Prompt(command.phrase, "espeak", voice, 1.0, 0.5)])
        heard = recognizer.transcribe(frozen_samples(np.pad(sound, RATE // 5))).text
        assert called.get(heard) in (None, command.command), (heard, command.phrase)
        right += called.get(heard) == command.command
    assert right >= 0.8 * len(HELD_OUT) * len(commands)

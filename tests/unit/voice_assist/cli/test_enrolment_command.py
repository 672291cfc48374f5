# SPDX-License-Identifier: BSD-3-Clause
"""The verb `enroll` says at its start which phrases nobody could keep apart."""

import dataclasses

import pytest
import soundfile

from tests.unit.voice_assist.support.adaptable import Adaptable
from tests.unit.voice_assist.support.fake_speech import FakeRecognizer, say
from voice_assist import assembly, recognizer
from voice_assist.cli.enroll import EnrolRequest, enroll
from voice_assist.config import CONFIG_DIR, load_voice_config
from voice_assist.enrolment import build
from voice_assist.errors import VoiceError
from voice_assist.profile.manifest import ACTIVE, REFUSED
from voice_assist.profile.profile import create_profile
from voice_assist.types import RATE


def asked(tmp_path):
    nowhere = tmp_path / "no_such_folder"
    return EnrolRequest("ada", tmp_path, nowhere, None, None, again=False, settings=CONFIG_DIR)


def with_another(voice, phrase):
    new = dataclasses.replace(voice.commands.get("pull more"), phrase=phrase, spellings=())
    every = (*voice.commands.commands, new)
    commands = dataclasses.replace(voice.commands, commands=every)
    return dataclasses.replace(voice, commands=commands)


def test_phrases_too_alike_are_named_before_anything_is_recorded(tmp_path, capsys):
    with pytest.raises(VoiceError, match="no_such_folder"):
        enroll(with_another(load_voice_config(), "pull moore"), asked(tmp_path))
    printed = " ".join(capsys.readouterr().out.split())
    assert "warning: 'pull more' and 'pull moore'" in printed
    assert "too alike" in printed
    with pytest.raises(VoiceError, match="no_such_folder"):  # the shipped phrases
        enroll(load_voice_config(), asked(tmp_path))
    assert "warning" not in capsys.readouterr().out


def test_an_input_that_has_ended_is_said_in_words_and_nothing_is_lost(tmp_path, monkeypatch):
    def ended(prompt):
        raise EOFError

    monkeypatch.setattr(recognizer, "load_recognizer", lambda *_, **__: Adaptable())
    wanted = dataclasses.replace(asked(tmp_path), wavs=None)
    with pytest.raises(VoiceError, match=r"input has ended .* what was recorded is kept"):
        enroll(load_voice_config(), wanted, ask=ended)
    assert (tmp_path / "ada").is_dir()


def test_a_recogniser_that_cannot_be_adapted_is_refused_before_anything_is_asked(
    tmp_path, monkeypatch
):
    monkeypatch.setattr(recognizer, "load_recognizer", lambda *_, **__: FakeRecognizer())
    wanted, prompts = dataclasses.replace(asked(tmp_path), wavs=None), []
    with pytest.raises(VoiceError, match=r"'fake' cannot be adapted, allowed: the embedded model"):
        enroll(load_voice_config(), wanted, ask=prompts.append)
    assert not prompts and not list(tmp_path.iterdir())


def test_a_file_that_is_left_out_is_named_on_the_terminal(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(recognizer, "load_recognizer", lambda *_, **__: Adaptable())
    wavs = tmp_path / "wavs"
    wavs.mkdir()
    soundfile.write(wavs / "stop-1.wav", say("stop", 0.3, 0.3), RATE)
    (wavs / "tense-[b].m4a").touch()
    wanted = dataclasses.replace(asked(tmp_path / "profiles"), wavs=wavs)
    with pytest.raises(VoiceError, match="too few takes"):
        enroll(load_voice_config(), wanted)
    printed = " ".join(capsys.readouterr().out.split())
    assert "tense-[b].m4a is left out: its ending is '.m4a', allowed: .wav, " in printed
    assert "stop-1.wav: good 1 takes kept" in printed


@pytest.mark.parametrize(
    ("state", "words"),
    [
        (ACTIVE, "Profile ada stays as it was, active; what was learned anew failed its check:"),
        (REFUSED, "Profile ada was not activated:"),
    ],
)
def test_the_terminal_distinguishes_a_profile_that_was_kept_from_a_refused_one(
    tmp_path, monkeypatch, capsys, state, words
):
    def failed(profile, *_):
        profile.judge(state, ("takes: 3 of 21 right",) if state == REFUSED else ())
        return ("takes: 3 of 21 right",)

    monkeypatch.setattr(recognizer, "load_recognizer", lambda *_, **__: Adaptable())
    monkeypatch.setattr(build, "build", failed)
    create_profile("ada", "ab" * 32, tmp_path)
    wanted = dataclasses.replace(asked(tmp_path), wavs=None, again=True)
    assert enroll(load_voice_config(), wanted) == 1
    printed = " ".join(capsys.readouterr().out.split())
    assert printed.endswith(f"{words} takes: 3 of 21 right")


def test_the_threads_of_the_settings_hold_before_anything_is_computed(tmp_path, monkeypatch):
    done = []

    def load(*_, **__):
        done.append("load")
        raise VoiceError("enough")

    monkeypatch.setattr(assembly, "limit_torch", lambda voice: done.append("limit"))
    monkeypatch.setattr(recognizer, "load_recognizer", load)
    with pytest.raises(VoiceError, match="enough"):
        enroll(load_voice_config(), dataclasses.replace(asked(tmp_path), wavs=None))
    assert done == ["limit", "load"]

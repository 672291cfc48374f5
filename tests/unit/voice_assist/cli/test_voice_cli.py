# SPDX-License-Identifier: BSD-3-Clause
import numpy as np
import pytest
import soundfile
from rich.console import Console

from tests.unit.voice_assist.support.fake_speech import FakeRecognizer, make_detector, say
from typed_config import package_version
from voice_assist.audio.capture import portaudio
from voice_assist.cli import listen as listen_module
from voice_assist.cli.listen import Screen, row
from voice_assist.cli.main import main
from voice_assist.pipeline.pipeline import Pipeline
from voice_assist.types import (
    Hypothesis,
    Lost,
    Match,
    Mode,
    NoMatch,
    Partial,
    Rejection,
    RejectionReason,
    UtteranceDecision,
)


def test_it_names_its_version(capsys):
    with pytest.raises(SystemExit, match="0"):
        main(["--version"])
    assert capsys.readouterr().out == f"voice_assist {package_version('voice_assist')}\n"


def test_phrases_prints_all_that_is_accepted(capsys):
    main(["phrases"])
    shown = capsys.readouterr().out
    for phrase in ("hey robot", "tense", "release", "pull more", "pull less", "terminate"):
        assert phrase in shown
    assert "'stop stop'" in shown
    assert "stop         in standby and active" in shown


def test_phrases_of_another_language_are_printed_as_they_are_written(capsys):
    main(["--language", "ja", "phrases"])
    shown = capsys.readouterr().out
    assert "'組織を離して'" in shown
    assert "ストップ" in shown
    assert "'すとっぷ'" not in shown


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        ([], "verb"),
        (["dance"], "invalid choice"),
        (["listen", "--speed", "-1", "--wav", "x"], "allowed: 0 to 1000"),
        (["listen", "--wav", "x", "--device", "y"], "not allowed with"),
        (["evaluate"], "required"),
        (["evaluate", "x.csv", "--out", "y", "--jobs", "0"], "a whole number from 1"),
        (["evaluate", "none.csv", "--out", "out.json"], "none.csv: No such file"),
        (["evaluate", "x.csv", "--out", "y", "--snr", "3"], "give both"),
        (["evaluate", "x.csv", "--out", "y", "--mode", "asleep"], "invalid choice"),
        (["--config", "nowhere", "phrases"], "a readable file"),
        (["listen", "--wav", "none.wav", "--model", "none.pt"], "none.wav: no such file"),
        (["listen", "--model", "none.pt"], "none.pt"),
        (["enroll", "ada", "--from-wavs", "nowhere"], "nowhere: no such folder"),
        (["enroll", "ada", "--corrections", "c.csv"], "--corrections needs --from-session"),
        (["profiles", "show", "--profiles", "nowhere"], "needs the name of a profile"),
        (["listen", "--profile", "../x"], "listen: profile.name is '../x', allowed: up to 40"),
        (["convert-model", "/dev/null", "--out", "x"], "/dev/null: empty, and no Whisper model"),
        (["alarms", "--play", "gong"], "invalid choice"),
        (["alarms", "--write-wav", "/dev/null/x"], "/dev/null/x: cannot be written (Not a dir"),
        (["alarms", "--write-wav", "/dev/null"], "/dev/null: cannot be written, it is a file"),
        (["alarms", "--markdown", "--write-wav", "x"], "leave out --play and --write-wav"),
        (["alarms", "--markdown", "--play"], "leave out --play and --write-wav"),
        (["--config", "nowhere", "alarms"], "alarms.yaml"),
    ],
)
def test_wrong_arguments_end_with_2_and_say_why(arguments, problem, capsys):
    with pytest.raises(SystemExit, match="2"):
        main(arguments)
    assert problem in capsys.readouterr().err


def decision(outcome, text="pull more"):
    return UtteranceDecision(
        hypothesis=Hypothesis(text, -0.1, 0.0),
        outcome=outcome,
        confidence=0.93,
        mode=Mode.ACTIVE,
        speech_start=1.0,
        speech_end=1.5,
        decided=1.72,
        is_partial=True,
    )


def test_a_row_shows_all_there_is_to_know():
    assert row(decision(Match("pull more", {"pull more": 0.0}))) == (
        *("pull more", "pull more", "0.00", "0.93", "220 ms", ""),
    )
    rejection = Rejection(RejectionReason.NO_COMMAND, "too far")
    refused = row(decision(NoMatch(rejection, "tense", {"tense": 2.0}), "hello there"))
    assert refused == ("hello there", "(tense)", "2.00", "0.93", "220 ms", "too far")


def test_the_screen_shows_level_partial_mode_and_trouble():
    screen = Screen(Mode.ACTIVE)
    screen.show(Partial("pull", 1.0))
    screen.show(Lost(160, 1.0))
    screen.show(decision(Match("pull more", {"pull more": 0.0})))
    screen.trouble = "microphone 'usb': not found"
    console = Console(width=120, record=True, file=open("/dev/null", "w"))  # noqa: SIM115, PTH123
    console.print(screen)
    shown = console.export_text()
    for part in ("active", "-60 dB", " pull", "160 samples lost", "pull more", "'usb': not found"):
        assert part in shown


def test_listen_plays_a_recording_and_shows_the_commands(tmp_path, monkeypatch, capsys):
    path = tmp_path / "sound.wav"
    soundfile.write(path, np.asarray(say("hey robot 0.8 tense")), 16_000)
    hears = FakeRecognizer(), make_detector()
    make = lambda config, clock: Pipeline(config, *hears, clock)  # noqa: E731
    monkeypatch.setattr(listen_module, "make_pipeline", make)
    main(["listen", "--wav", str(path), "--speed", "0"])
    shown = capsys.readouterr().out
    assert "hey robot" in shown and "tense" in shown and "active" in shown


def test_without_a_terminal_each_piece_of_news_is_a_line_as_it_comes(capsys):
    lines = listen_module.Lines(Mode.STANDBY)
    lines.note("no microphone", Mode.STANDBY)
    lines.note("no microphone", Mode.STANDBY)
    lines.show(Partial("pull", 0.0))
    lines.show(decision(Match("pull more", {"pull more": 0.0})))
    lines.show(Lost(512, 0.0))
    lines.note("", Mode.ACTIVE)
    assert capsys.readouterr().out.splitlines() == [
        "trouble: no microphone",
        "pull more  pull more  0.00  0.93  220 ms",
        "512 samples lost",
        "sound comes in",
        "mode: active",
    ]


def test_microphones_are_listed_by_name_and_it_is_said_where_there_is_none(monkeypatch, capsys):
    found = [portaudio.Device("USB", 48_000, False), portaudio.Device("pulse", 44_100, True)]
    monkeypatch.setattr(portaudio.PortAudio, "devices", lambda self: found)
    main(["devices"])
    assert capsys.readouterr().out == "USB  48000 Hz\npulse  44100 Hz  (default)\n"
    found.clear()
    with pytest.raises(SystemExit, match="1"):
        main(["devices"])
    assert "no microphone found" in capsys.readouterr().out

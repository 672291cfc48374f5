# SPDX-License-Identifier: BSD-3-Clause
"""Enrolment for a screen and from recorded sessions."""

import csv
import dataclasses
import sys
from io import StringIO
from pathlib import Path
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest
from rich.console import Console

from tests.unit.voice_assist.support.adaptable import Adaptable
from tests.unit.voice_assist.support.fake_speech import FakeRecognizer, frames, say, silence
from voice_assist.cli.enroll_terminal import guide
from voice_assist.config import load_voice_config
from voice_assist.config.enrolment import load_enrolment_config
from voice_assist.enrolment import remote_session
from voice_assist.enrolment.remote_session import EnrolmentService
from voice_assist.enrolment.takes.checks import TakeCheck
from voice_assist.enrolment.takes.from_session import COLUMNS, Uncorrected, read_takes
from voice_assist.enrolment.takes.script import EnrolmentScript
from voice_assist.errors import ManifestError
from voice_assist.profile.deletion import delete_profile
from voice_assist.profile.manifest import ACTIVE, COMMAND, TALK
from voice_assist.profile.profile import VoiceProfileError, create_profile, open_profile
from voice_assist.types import FULL_SCALE

VOICE = load_voice_config()
CONFIG = dataclasses.replace(load_enrolment_config(), talk=0.0, room=1.0)
PHRASES = VOICE.commands.phrases


def heard(text):
    yield from frames(say(text, 0.5, 4.0) if text else silence(5.0).astype(np.float32))


class Room:
    """A room in which a person says what was put on a list."""

    def __init__(self):
        self.said, self.is_armed = [], False

    def listen(self):
        return heard(self.said.pop(0))


@pytest.fixture
def room():
    return Room()


@pytest.fixture
def service(room, tmp_path):
    args = VOICE, CONFIG, Adaptable({"stop": 9.0}), tmp_path, room.listen, lambda: room.is_armed
    return EnrolmentService(*args)


def test_a_screen_is_led_through_the_script(service, room, tmp_path):
    result = service("ada", "next")
    assert result.step.kind == "room"
    room.said = ["", "hey robot", "tense"]
    for expected in ("hey robot", "tense", "release"):
        result = service("ada", "record")
        assert result.success, result.message
        assert result.step.phrase == expected
    assert len(open_profile("ada", tmp_path).manifest.takes) == 3


def test_a_wrong_word_is_asked_for_again(service, room):
    room.said = ["", "stop"]
    service("ada", "record")
    result = service("ada", "record")
    assert not result.success
    assert "wrong word: 'stop' was heard" in result.message
    assert result.step.phrase == "hey robot"


def test_what_a_terminal_did_meanwhile_is_gone_on_from(service, room, tmp_path):
    room.said = ["", "tense"]
    service("ada", "record")
    terminal = open_profile("ada", tmp_path)
    take = dataclasses.replace(terminal.manifest.takes[0], kind=COMMAND, phrase="hey robot")
    terminal.add_take(say("hey robot", 0.5, 0.5), take)
    result = service("ada", "record")
    assert result.success, result.message
    takes = open_profile("ada", tmp_path).manifest.takes
    assert [take.phrase for take in takes] == ["", "hey robot", "tense"]


def test_what_a_terminal_did_while_a_take_was_recorded_is_kept(service, room, tmp_path):
    room.said = ["", "hey robot"]
    service("ada", "record")

    def interrupted():
        open_profile("ada", tmp_path).put("note.txt", b"by a terminal")
        yield from room.listen()

    service._listen = interrupted
    assert service("ada", "record").success
    assert open_profile("ada", tmp_path).read("note.txt") == b"by a terminal"


def test_a_profile_that_was_deleted_meanwhile_begins_anew(service, room, tmp_path):
    room.said = [""]
    service("ada", "record")
    delete_profile("ada", tmp_path)
    result = service("ada", "next")
    assert result.step.kind == "room"
    assert open_profile("ada", tmp_path).manifest.takes == ()


def test_a_profile_that_was_deleted_while_a_take_was_recorded_is_named(service, tmp_path):
    service("ada", "next")

    def interrupted():
        delete_profile("ada", tmp_path)
        yield from heard("")

    service._listen = interrupted
    result = service("ada", "record")
    assert not result.success
    assert "no profile 'ada'" in result.message
    assert not (tmp_path / "ada").exists()


def test_a_take_unlike_the_base_is_kept_when_it_comes_again(service, room):
    room.said = ["", "mumble", "mumble"]
    assert [service("ada", "record").success for _ in range(3)] == [True, False, True]


def test_nothing_is_recorded_while_commands_move_the_robot(service, room, tmp_path):
    room.is_armed = True
    result = service("ada", "record")
    assert not result.success
    assert "say terminate before you enrol" in result.message
    assert not open_profile("ada", tmp_path).manifest.takes


def test_nothing_is_learned_while_commands_move_the_robot(service, room, monkeypatch):
    built = []
    monkeypatch.setattr(remote_session, "build", lambda *_, **__: built.append("built"))
    room.is_armed = True
    result = service("ada", "learn")
    assert not result.success and "say terminate before you enrol" in result.message
    assert built == []
    room.is_armed = False
    assert service("ada", "learn").success
    assert built == ["built"]


def test_the_answer_to_a_screen_says_that_an_active_profile_stays_as_it_was(
    service, tmp_path, monkeypatch
):
    monkeypatch.setattr(remote_session, "build", lambda *_, **__: ("takes: 3 of 21 right",))
    assert service("ada", "learn").message == "takes: 3 of 21 right"
    open_profile("ada", tmp_path).judge(ACTIVE)
    result = service("ada", "learn")
    assert not result.success
    assert result.message == "takes: 3 of 21 right; the profile stays as it was"


@pytest.mark.parametrize(
    ("name", "action", "message"),
    [
        ("ada", "sing", "action 'sing', allowed: next, record, learn"),
        ("../ada", "next", "profile name"),
        ("ada", "learn", "too few takes of 'hey robot' 0, "),
    ],
)
def test_what_cannot_be_done_is_named(service, name, action, message):
    result = service(name, action)
    assert not result.success
    assert message in result.message


def test_a_recogniser_that_cannot_be_adapted_is_refused_before_anything_is_recorded(room, tmp_path):
    words = "recogniser 'fake' cannot be adapted, allowed: the embedded model"
    with pytest.raises(VoiceProfileError, match=words):
        EnrolmentService(VOICE, CONFIG, FakeRecognizer(), tmp_path, room.listen, lambda: False)


# --- recorded sessions


def recorded(time, text, command):
    samples = np.rint(say(text, 0.3, 0.3) * FULL_SCALE).astype(np.int16)
    return SimpleNamespace(time=time, heard=text, command=command, samples=samples)


@pytest.fixture
def reader(monkeypatch):
    module = ModuleType("fake_sessions")
    said = [("tense", "tense"), ("mumble", ""), ("he said", ""), ("stop", "stop")]
    found = [recorded(float(i), *words) for i, words in enumerate(said)]
    module.read = lambda path: found
    monkeypatch.setitem(sys.modules, "fake_sessions", module)
    return "fake_sessions:read"


def correct(path, said):
    with path.open(newline="") as file:
        rows = list(csv.DictReader(file))
    with path.open("w", newline="") as file:
        table = csv.DictWriter(file, COLUMNS)
        table.writeheader()
        for row in rows:
            table.writerow({**row, "said": said.get(int(row["number"]), row["said"])})


def test_a_session_that_was_corrected_becomes_takes_once_and_no_other(tmp_path, reader):
    path, session_path = tmp_path / "said.csv", tmp_path / "session.mcap"
    with pytest.raises(Uncorrected, match=r"said.csv was written; correct the column said"):
        read_takes(session_path, path, PHRASES, reader)
    rows = list(csv.DictReader(path.open()))
    assert [row["said"] for row in rows] == ["tense", "", "", "stop"]
    correct(path, {2: "release", 3: "talk", 4: ""})
    takes = read_takes(session_path, path, PHRASES, reader)
    found = [(take.kind, take.phrase) for take in takes]
    assert found == [(COMMAND, "tense"), (COMMAND, "release"), (TALK, "")]
    profile = create_profile("ada", "ab" * 32, tmp_path / "profiles")
    check = TakeCheck(CONFIG.checks, VOICE.commands, FakeRecognizer({"release": -5.0}))
    script = EnrolmentScript(profile, CONFIG, PHRASES, check)
    assert script.take_over(takes, lambda *_: None) == 3
    assert script.take_over(takes, lambda *_: None) == 0
    assert [take.phrase for take in profile.manifest.takes] == ["tense", "release", ""]


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        ("1,0,0.85,banana\n", r"row 2: said 'banana', allowed: hey robot, .*, or nothing"),
        ("1,,,\n5,,,stop\n", "row 3: number '5', allowed: 1 to 4"),
        ("one,,,stop\n", "row 2: number 'one', allowed: 1 to 4"),
        ("1,0,0.85,stop\n2,7.00,0.85,stop\n", r"row 3: time '7.00', allowed: 1.00, as in .*mcap"),
        ("1,0,0.86,stop\n", "row 2: seconds '0.86', allowed: 0.85, as in .*mcap; was it written"),
        ("1,,0.85,stop\n", "row 2: time '', allowed: 0.00"),
        ("", "said.csv: the column said is empty; write a command or talk there"),
        ("1,,,\n", "said.csv: the column said is empty"),
    ],
)
def test_a_correction_that_cannot_be_used_is_refused(tmp_path, reader, lines, words):
    path = tmp_path / "said.csv"
    path.write_text(f"number,time,seconds,said\n{lines}")
    with pytest.raises(ManifestError, match=words):
        read_takes(tmp_path / "session.mcap", path, PHRASES, reader)


@pytest.mark.parametrize("column", ["number", "time", "seconds", "said"])
def test_corrections_without_a_column_are_refused(tmp_path, reader, column):
    columns = [name for name in ("number", "time", "seconds", "said") if name != column]
    path = tmp_path / "said.csv"
    path.write_text(f"{','.join(columns)}\n1,0,stop\n")
    words = f"no column '{column}'; columns are: {', '.join(columns)}"
    with pytest.raises(ManifestError, match=words):
        read_takes(tmp_path / "session.mcap", path, PHRASES, reader)


def test_a_file_of_corrections_that_exists_is_kept_and_named(tmp_path, reader, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("corrections.csv").write_text("kept")
    with pytest.raises(ManifestError, match=r"corrections.csv exists already; name it or another"):
        read_takes(tmp_path / "session.mcap", None, PHRASES, reader)
    assert Path("corrections.csv").read_text() == "kept"


def test_a_session_in_which_nothing_was_said_leaves_no_file(tmp_path, reader, monkeypatch):
    monkeypatch.setattr("fake_sessions.read", lambda path: [])
    with pytest.raises(ManifestError, match=r"no utterance with its sound .* nothing was written"):
        read_takes(tmp_path / "session.mcap", tmp_path / "said.csv", PHRASES, reader)
    assert not (tmp_path / "said.csv").exists()


@pytest.mark.parametrize("name", ["nowhere:read", "json:nothing", "json"])
def test_a_reader_that_is_not_there_is_named(tmp_path, name):
    with pytest.raises(ManifestError, match=f"session_reader '{name}'"):
        read_takes(tmp_path, None, PHRASES, name)


# --- the terminal


class Microphone:
    """Gives what is said next, from the moment it is opened."""

    opened = 0

    def __init__(self, said):
        self._said = said

    def __enter__(self):
        Microphone.opened += 1
        return self

    def __exit__(self, *_):
        Microphone.opened -= 1

    def __iter__(self):
        return heard(self._said.pop(0))


def test_the_terminal_asks_again_and_goes_on_after_ctrl_c(tmp_path):
    profile = create_profile("ada", "ab" * 32, tmp_path / "profiles")
    config = dataclasses.replace(CONFIG, repetitions=3)
    check = TakeCheck(config.checks, VOICE.commands, Adaptable({"stop": 9.0}))
    said = ["", "stop", "hey robot", "tense"]
    asked = []

    def ready(step):
        assert Microphone.opened == 0  # nobody listens until the person is ready
        asked.append(step.phrase)
        if not said:
            raise KeyboardInterrupt

    shown = StringIO()
    console = Console(file=shown, width=100)
    with pytest.raises(KeyboardInterrupt):
        guide(EnrolmentScript(profile, config, PHRASES, check), Microphone(said), console, ready)
    assert asked == ["", "hey robot", "hey robot", "tense", "release"]
    assert "wrong word: 'stop' was heard" in shown.getvalue()
    assert "once more, please" in " ".join(shown.getvalue().split())
    again = open_profile("ada", tmp_path / "profiles")
    rest = EnrolmentScript(again, config, PHRASES, check).next()
    assert (rest.phrase, rest.number, rest.total) == ("release", 3, 21)

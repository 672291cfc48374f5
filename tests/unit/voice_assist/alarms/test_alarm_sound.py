# SPDX-License-Identifier: BSD-3-Clause
"""Playing: one at a time, the higher first, a stuck or missing device delays nobody."""

import sys
import threading
from dataclasses import replace

import pytest
import soundfile

from support.waiting import wait_until
from typed_config import load_file
from voice_assist.alarms.earcons import PATTERNS
from voice_assist.alarms.player import Player
from voice_assist.alarms.presenter import latch_alarm
from voice_assist.alarms.sound_output import ProgramOutput, player_command, write_sounds
from voice_assist.alarms.types import Alarm, Earcon, Kind, Priority
from voice_assist.cli.main import main
from voice_assist.config.alarms import FILE, AlarmsConfig
from voice_assist.errors import AudioError
from voice_assist.types import RATE

SOON = 10.0  # [s] that a thread may take on a busy machine
CONFIG = load_file(AlarmsConfig, FILE).sound
HIGH = latch_alarm("tension 2.50 N, allowed 2.40 N", "over_tension", is_loaded=True)
STOP = latch_alarm("stopped by voice", "stop_topic", is_loaded=False)
REFUSAL = Alarm(Kind.REFUSAL, Priority.LOW, "busy", "Wait.", Earcon.REFUSAL)


class Device:
    """A sound device that plays until a test lets it go on, or until it is cut."""

    def __init__(self):
        self.began = []
        self.cut = []
        self.at_once = 0
        self.trouble = ""
        self._go_on = threading.Event()
        self._began = threading.Condition()

    def play(self, earcon, is_cut):
        with self._began:
            self.at_once += 1
            assert self.at_once == 1
            self.began.append(earcon)
            self._began.notify_all()
        try:
            if self.trouble:
                raise AudioError(self.trouble)
            while not self._go_on.wait(0.005):
                if is_cut():
                    self.cut.append(earcon)
                    return
        finally:
            self.at_once -= 1

    def go_on(self):
        self._go_on.set()

    def wait_for(self, count):
        with self._began:
            assert self._began.wait_for(lambda: len(self.began) >= count, SOON), self.began


@pytest.fixture
def device():
    return Device()


@pytest.fixture
def reported():
    return []


@pytest.fixture
def player(device, reported):
    with Player(device, reported.append) as player:
        yield player
        device.go_on()


def test_a_higher_priority_cuts_off_a_lower_one(player, device):
    player.offer(STOP)
    device.wait_for(1)
    player.offer(HIGH)
    device.wait_for(2)
    assert device.began == [Earcon.STOP, Earcon.FAULT_HIGH] and device.cut == [Earcon.STOP]


def test_a_lower_priority_waits_for_its_turn(player, device):
    player.offer(HIGH)
    device.wait_for(1)
    player.offer(REFUSAL)
    assert device.cut == []
    device.go_on()
    device.wait_for(2)
    assert device.began == [Earcon.FAULT_HIGH, Earcon.REFUSAL] and device.cut == []


def test_of_what_waits_for_a_stuck_device_only_the_most_urgent_is_kept(player, device):
    """`offer` returns although nothing goes on: a thousand offers queue one sound."""
    player.offer(HIGH)
    device.wait_for(1)
    for _ in range(500):
        player.offer(REFUSAL)
        player.offer(STOP)
    player.offer(REFUSAL)
    device.go_on()
    device.wait_for(2)
    assert device.began == [Earcon.FAULT_HIGH, Earcon.STOP]


def test_trouble_is_reported_once_and_its_end_too(player, device, reported):
    device.trouble = "no sound device"
    for count in (1, 2, 3):
        player.offer(STOP)
        device.wait_for(count)
    device.trouble = ""
    device.go_on()
    player.offer(STOP)
    device.wait_for(4)
    wait_until(lambda: reported == ["no sound device", ""])
    player.__exit__()
    assert reported == ["no sound device", ""]


class Speaker:
    """Says answers, or fails to."""

    def __init__(self):
        self.said = []
        self.trouble = ""

    def prepare(self):
        """Nothing takes time."""

    def say(self, sentence, is_cut):
        if self.trouble:
            raise AudioError(self.trouble)
        self.said.append(sentence)


def test_a_missing_answer_is_distinguished_from_a_missing_tone(device, reported):
    speaker, unspoken = Speaker(), []
    answered = replace(STOP, answer="stopped")
    device.go_on()
    player = Player(device, reported.append, speaker, report_answers=unspoken.append)
    for tone, answer in [("", ""), ("", "stuck"), ("", "stuck"), ("x", "")]:
        device.trouble, speaker.trouble = tone, answer
        player._play(answered)
    assert reported == ["x"]
    assert unspoken == ["no answer is spoken: stuck"]
    assert speaker.said == ["stopped"]


# Programs of the system, in place of which a Python one stands here.


def output(*command, **changes):
    config = replace(CONFIG, **{"stuck_after": 0.2, **changes})
    return ProgramOutput(config, [sys.executable, "-c", *command])


def never():
    return False


def test_the_program_gets_the_file_of_the_sound(tmp_path):
    note = tmp_path / "note"
    code = f"import sys, pathlib; pathlib.Path({str(note)!r}).write_text(sys.argv[1])"
    with output(code, stuck_after=20.0) as out:
        out.play(Earcon.STOP, never)
    assert note.read_text().endswith("stop.wav")


def test_a_program_that_never_ends_is_ended_and_reported():
    with output("import time; time.sleep(600)") as out, pytest.raises(AudioError) as error:
        out.play(Earcon.ACCEPTED, never)
    assert "does not end a sound within 0.3 s" in str(error.value)


def test_a_sound_is_cut_where_it_is_asked_for():
    with output("import time; time.sleep(600)", stuck_after=30.0) as out:
        out.play(Earcon.FAULT_HIGH, lambda: True)  # returns


def test_what_the_program_complains_of_is_passed_on():
    code = "import sys; sys.exit('Connection failure: Connection refused')"
    with output(code, stuck_after=20.0) as out, pytest.raises(AudioError, match="n refused"):
        out.play(Earcon.STOP, never)


def test_a_missing_program_is_named_with_its_package(monkeypatch):
    monkeypatch.setattr("shutil.which", lambda _: None)
    with pytest.raises(AudioError, match="pulseaudio-utils"):
        player_command("pulse:speaker")
    with pytest.raises(AudioError, match="alsa-utils"):
        player_command("")


def test_devices_are_named_by_their_system(monkeypatch):
    monkeypatch.setattr("shutil.which", lambda name: f"/bin/{name}")
    assert player_command("pulse:speaker") == ["/bin/paplay", "--device=speaker"]
    assert player_command("alsa:hw:0") == ["/bin/aplay", "-q", "-D", "hw:0"]
    assert player_command("") == ["/bin/paplay"]
    with pytest.raises(AudioError, match="'speaker', allowed: pulse:<sink>"):
        player_command("speaker")


def test_every_sound_is_written_as_a_file(tmp_path):
    for path in write_sounds(tmp_path, -6.0):
        sound, rate = soundfile.read(path)
        duration = PATTERNS[Earcon(path.stem)].duration
        assert rate == RATE and duration <= len(sound) / RATE < duration + 0.1
        assert 0.1 < abs(sound).max() <= 0.51
    assert {path.stem for path in tmp_path.iterdir()} == {e.value for e in Earcon}


# The command line.


def test_the_command_shows_every_alarm_with_what_to_do(capsys):
    main(["alarms"])
    shown = capsys.readouterr().out
    for words in ("FAULT !!! HIGH", "STOP !! MEDIUM", "REFUSAL ! LOW", "red, flashing", "next:"):
        assert words in shown


def test_the_command_writes_sounds(tmp_path, capsys):
    main(["alarms", "--write-wav", str(tmp_path / "new" / "folder")])
    assert len(list((tmp_path / "new" / "folder").glob("*.wav"))) == len(Earcon)
    assert "fault-high.wav" in capsys.readouterr().out


def test_without_a_way_out_the_command_says_so(monkeypatch, capsys):
    monkeypatch.setattr("shutil.which", lambda _: None)
    with pytest.raises(SystemExit) as ended:
        main(["alarms", "--play", "stop"])
    assert ended.value.code == 2 and "alsa-utils" in capsys.readouterr().err

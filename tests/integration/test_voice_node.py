# SPDX-License-Identifier: BSD-3-Clause
"""The voice node on a master of its own, with a recogniser that hears tones."""

import itertools
import json
import os
import re
import signal
import subprocess
import sys
import threading
import time
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

import numpy as np
import pytest
import rosgraph
import soundfile
import soxr
import yaml

from demo.virtual_microphone import VirtualMicrophone
from rst_control.host.respawn import RESTART
from support.waiting import PATIENCE, wait_until
from tests.support.ros_host import Host
from tests.unit.voice_assist.support.fake_speech import say

ROOT = Path(__file__).resolve().parents[2]
PROGRAMS = Path(__file__).parent / "programs"
NODE = [sys.executable, str(PROGRAMS / "fake_voice_node.py"), "__name:=voice_assist"]
HANG = 30.0  # [s] as in voice_witness.py
ANSWERED = 20.0  # [s] for an answer on a loaded machine
NOBODY = {"commands/answer_within": 5.0}  # where nobody answers
LOOK, LONGER = 0.2, 1.0  # [s] between two looks at what was seen, and after the last one
DEBUG, INFO, WARN, ERROR = 1, 2, 4, 8


@pytest.fixture(scope="module")
def master(tmp_path_factory):
    """Environment of a roscore that only this file uses."""
    host = Host(tmp_path_factory.mktemp("master"))
    try:
        host.start_master()
        yield host.environment
    finally:
        host.close()


def watch(master, folder, is_enough, behaviour=(), **settings):
    """What a witness saw while the node ran with the given settings, and what the node printed.

    Until that is enough, and a moment longer, in which nothing may come that should not.
    """
    out, printed = folder / "seen.json", folder / "printed.txt"

    def read():
        return {**json.loads(out.read_text("utf-8")), "printed": printed.read_text("utf-8")}

    load(master, {"audio/source": "wav", "commands/answer_within": ANSWERED, **settings})
    witness = [sys.executable, str(PROGRAMS / "voice_witness.py"), str(out), *behaviour]
    processes = []
    try:
        processes.append(subprocess.Popen(witness, env=master))
        wait_until(out.exists, "the witness")
        with printed.open("wb") as file:
            processes.append(subprocess.Popen(NODE, env=master, stdout=file, stderr=file))
        with suppress(RuntimeError):  # what is missing is shown by who asks for it
            wait_until(lambda: is_enough(read()), every=LOOK)
            time.sleep(LONGER)
    finally:
        for process in reversed(processes):
            process.send_signal(signal.SIGINT)
            process.wait(PATIENCE)
    return read()


def errors(seen):
    """What the node printed as errors; /rosout may lose those of its first moments."""
    return re.findall(r"\[ERROR\] \[[^]]*\]: ([^\x1b\n]*)", seen["printed"])


def load(master, settings):
    """Put the package's settings on the parameter server, with some changed."""
    folder = ROOT / "catkin_ws" / "src" / "voice_assist" / "config"
    names = ("audio", "recognizer", "spotter", "commands", "believed")
    given = {name: yaml.safe_load((folder / f"{name}.yaml").read_text()) for name in names}
    given["believed"] |= {"audio": ["/witness"], "speaker": ["/witness"]}
    given["spotter"]["is_enabled"] = False  # it was trained on words, and here tones are spoken
    for path, value in settings.items():
        *parents, key = path.split("/")
        branch = given
        for parent in parents:
            branch = branch[parent]
        branch[key] = value if isinstance(value, (int, float)) else str(value)
    given["launched"] = json.dumps(given)  # as its first start keeps it
    rosgraph.Master("/test", master["ROS_MASTER_URI"]).setParam("/voice_assist", given)


def firsts(seen, kind):
    return [entry[0] for entry in seen.get(kind, [])]


@pytest.fixture(scope="module")
def session(master, tmp_path_factory):
    """One spoken session: what the witness saw."""
    folder = tmp_path_factory.mktemp("session")
    sound = say("0.5 tense 1 hey robot 1 tense 1 he said pull more 1 pull more 1 stop 1 terminate")
    soundfile.write(folder / "sound.wav", sound, 16_000)
    return watch(
        master,
        folder,
        lambda seen: len(firsts(seen, "say")) >= 5 and firsts(seen, "mode")[2:],
        ["pull more=refuse"],
        **{"audio/wav/path": folder / "sound.wav"},
    )


def test_the_commands_reach_the_controller_in_order(session):
    assert firsts(session, "call") == ["hey robot", "tense", "pull more", "stop", "terminate"]
    assert {entry[1] for entry in session["call"]} == {"/voice_assist"}


def test_stop_is_also_sent_on_its_own_topic_once(session):
    assert len(session["stop"]) == 1


def test_the_mode_follows_the_words(session):
    assert firsts(session, "mode") == ["standby", "active", "standby"]


def test_every_utterance_is_published_with_its_error_rates(session):
    taken = [(entry[0], entry[1]) for entry in session["utterance"]]
    assert taken == [
        ("tense", ""),
        ("hey robot", "hey robot"),
        ("tense", "tense"),
        ("he said pull more", ""),
        ("pull more", "pull more"),
        ("stop", "stop"),
        ("terminate", "terminate"),
    ]
    assert "counts only in active mode" in session["utterance"][0][2]
    assert session["utterance"][2][4]["tense"] == 0.0
    assert len(session["utterance"][2][4]) == 7


def test_a_refusal_by_the_controller_is_shown(session):
    warnings = [entry[2] for entry in session["log"] if entry[1] == WARN]
    assert "pull more refused: nothing is grasped" in warnings


def test_replies_are_given_in_words_that_may_be_said_aloud(session):
    assert firsts(session, "say") == [
        "arm it is",
        "tightens it is",
        "nothing is grasped",
        "halts it is",
        "ends it is",
    ]


def test_while_the_robot_itself_speaks_only_a_stop_counts(master, tmp_path):
    soundfile.write(tmp_path / "sound.wav", say("0.5 hey robot 1 stop"), 16_000)
    settings = {"audio/wav/path": tmp_path / "sound.wav", "audio/robot_speech/max_duration": 60.0}
    seen = watch(master, tmp_path, lambda seen: "stop" in seen, ["robot=speaking"], **settings)
    assert firsts(seen, "call") == ["stop"]
    assert firsts(seen, "mode") == ["standby"]
    assert len(seen["stop"]) == 1
    assert seen["utterance"][0][2] == "the robot itself was speaking; say it again"


def test_the_sound_is_published_without_gaps(session):
    first = firsts(session, "audio")
    assert len(first) > 300
    assert {b - a for a, b in itertools.pairwise(first)} == {512}
    assert {entry[1] for entry in session["audio"]} == {16_000}


def test_what_is_being_heard_is_published_as_it_grows(session):
    partials = firsts(session, "partial")
    beginnings = ("he", "he said", "he said pull", "he said pull more")  # a busy machine looks less
    assert not set(beginnings).isdisjoint(partials)
    assert any(a and b.startswith(f"{a} ") for a, b in itertools.pairwise(partials))
    assert partials[-1] == ""


def test_heartbeats_go_on_while_it_listens(session):
    beats = firsts(session, "heartbeat")
    assert len(beats) > 50
    assert "listening" in [entry[1] for entry in session["diagnostics"]]


def test_a_controller_that_hangs_does_not_delay_hearing(master, tmp_path):
    soundfile.write(tmp_path / "sound.wav", say("hey robot 0.7 tense 0.7 stop"), 16_000)
    settings = {"audio/wav/path": tmp_path / "sound.wav", **NOBODY}
    hang = ["tense=hang"]
    seen = watch(master, tmp_path, lambda seen: "stop" in firsts(seen, "call"), hang, **settings)
    hung = next(entry[-1] for entry in seen["call"] if entry[0] == "tense")
    (stop,) = seen["stop"]
    assert stop[-1] - hung < HANG, "the stop did not wait for the answer"
    assert [entry[1] for entry in seen["utterance"]] == ["hey robot", "tense", "stop"]
    assert "stop" in firsts(seen, "call"), "a new connection was made"


def test_without_a_controller_that_is_said_and_hearing_goes_on(master, tmp_path):
    soundfile.write(tmp_path / "sound.wav", say("hey robot 1 tense", after=2.0), 16_000)
    settings = {"audio/wav/path": tmp_path / "sound.wav", **NOBODY}
    missing = "controller is missing"

    def is_reported(seen):
        said = [entry[1] for entry in seen.get("diagnostics", [])]
        return len(firsts(seen, "utterance")) == 2 and any(missing in words for words in said)

    seen = watch(master, tmp_path, is_reported, ["service=missing"], **settings)
    assert [entry[1] for entry in seen["utterance"]] == ["hey robot", "tense"]
    warnings = [entry[2] for entry in seen["log"] if entry[1] == WARN]
    assert any("hey robot refused: the robot's controller is missing" in w for w in warnings)
    assert "refused by the robot" in seen["mode"][-1][1]
    assert any(missing in entry[1] for entry in seen["diagnostics"])


def test_without_a_microphone_it_lives_says_so_and_sends_no_heartbeat(master, tmp_path):
    settings = {"audio/source": "microphone", "audio/microphone/device": "no such microphone"}
    seen = watch(
        master, tmp_path, lambda seen: 2 in firsts(seen, "diagnostics") and errors(seen), **settings
    )
    assert any("'no such microphone': not found; microphones found:" in e for e in errors(seen))
    assert [e[0] for e in seen["diagnostics"] if "strangers" not in e[1]][-1] == 2
    assert "heartbeat" not in seen


def test_a_microphone_that_is_muted_or_overloaded_is_named_and_sends_no_heartbeat(master, tmp_path):
    rng = np.random.default_rng(1)
    soundfile.write(tmp_path / "room.wav", 0.01 * rng.standard_normal(3 * 16_000), 16_000)
    deafening = np.clip(10.0 * rng.standard_normal(3 * 16_000), -1.0, 1.0)
    soundfile.write(tmp_path / "deafening.wav", deafening, 16_000)
    with headset() as server:
        turns = itertools.cycle(["room", "", "room", "deafening"])
        over = threading.Event()

        def play():
            for name in turns:
                player = name and server.play(tmp_path / f"{name}.wav")
                if over.wait(3.0):
                    return
                if player:
                    player.wait(PATIENCE)

        playing = threading.Thread(target=play)
        playing.start()
        settings = {"audio/source": "microphone", "audio/microphone/device": "pulse:headset"}
        try:
            seen = watch({**master, **server.environment}, tmp_path, has_come_back, **settings)
        finally:
            over.set()
            playing.join()
    reported = faults(seen)
    assert any("gives one value alone for 1.5 s" in words for words, _ in reported), reported
    assert any("is overloaded for 1.5 s" in words for words, _ in reported), reported
    well = [at for _, _, words, at in seen["log"] if words == "sound comes in"]
    beats = [at for *_, at in seen["heartbeat"]]
    for _, at in reported:
        end = min((one for one in well if one > at), default=at)
        assert not [beat for beat in beats if at + 0.2 < beat < end - 0.2], "deaf, and it went on"
    assert any(beat > min(at for _, at in reported) for beat in beats), "it came back"
    assert any("muted, or dead" in entry[1] for entry in seen["diagnostics"])


def faults(seen):
    """Errors of a microphone, and when each was reported."""
    return [(words, at) for _, level, words, at in seen.get("log", []) if level == ERROR]


def has_come_back(seen):
    """Both faults were reported, and heartbeats came after them."""
    reported = faults(seen)
    kinds = {kind for kind in ("one value", "overloaded") for words, _ in reported if kind in words}
    beats = [at for *_, at in seen.get("heartbeat", [])]
    muted = any("muted, or dead" in entry[1] for entry in seen.get("diagnostics", []))
    return len(kinds) == 2 and muted and beats[-1] > max(at for _, at in reported)


@contextmanager
def headset():
    """A PulseAudio server on which the microphone "headset" hears what is played."""
    with ExitStack() as stack:
        try:
            server = stack.enter_context(VirtualMicrophone())
        except OSError as error:
            pytest.skip(f"no PulseAudio server: {error}")
        words = ["pactl", "load-module", "module-remap-source", "source_name=headset"]
        environment = {**os.environ, **server.environment}
        words += [f"master={server.device.removeprefix('pulse:')}"]
        subprocess.run(words, env=environment, check=True, capture_output=True)
        yield server


def is_over(seen):
    """The last word was heard, and then nothing."""
    return "stop" in seen and errors(seen)


def test_an_audio_topic_of_another_rate_is_heard_and_its_end_reported(master, tmp_path):
    sound = soxr.resample(say("hey robot 1 stop"), 16_000, 44_100)
    soundfile.write(tmp_path / "sound.wav", sound, 44_100)
    play = f"play={tmp_path / 'sound.wav'}"
    seen = watch(master, tmp_path, is_over, [play], **{"audio/source": "topic"})
    assert [entry[1] for entry in seen["utterance"]] == ["hey robot", "stop"]
    assert len(seen["stop"]) == 1
    assert any("no sound on /audio_in for 2.0 s" in error for error in errors(seen))


def test_the_sound_of_audio_common_is_heard_and_its_end_reported(master, tmp_path):
    soundfile.write(tmp_path / "sound.wav", say("1.5 hey robot 1 stop"), 16_000)
    play = f"play_data={tmp_path / 'sound.wav'}"
    seen = watch(master, tmp_path, is_over, [play], **{"audio/source": "audio_data"})
    assert [entry[1] for entry in seen["utterance"]] == ["hey robot", "stop"]
    assert any("no sound on /audio/audio for 2.0 s" in error for error in errors(seen))


def test_sound_of_another_format_is_named_and_not_heard(master, tmp_path):
    soundfile.write(tmp_path / "sound.wav", say("1.5 hey robot 1 stop"), 16_000)
    play, settings = f"play_data={tmp_path / 'sound.wav'}", {"audio/audio_data/channels": 2}
    settings["audio/source"] = "audio_data"
    seen = watch(
        master, tmp_path, lambda seen: "played" in seen and errors(seen), [play], **settings
    )
    assert "utterance" not in seen
    words = r"(\d\.\d\d) times real time if it is 2 x 16000 Hz S16LE"
    ratio = float(re.findall(words, "\n".join(errors(seen)))[-1])  # a pause weighs least in it
    assert ratio == pytest.approx(0.5, abs=0.1)  # a busy machine plays slower


def test_what_a_recording_has_said_is_not_said_again_after_a_crash(master, tmp_path):
    soundfile.write(tmp_path / "sound.wav", say("hey robot 1 tense"), 16_000)
    settings = {"audio/wav/path": tmp_path / "sound.wav"}
    seen = watch({**master, RESTART: "1"}, tmp_path, errors, **settings)
    assert "call" not in seen and "utterance" not in seen and "heartbeat" not in seen
    assert errors(seen) == ["a crash broke the recording off; nothing of it is said again"]


def test_a_recording_that_cannot_be_read_ends_it_with_one_line(master, tmp_path):
    load(master, {"audio/source": "wav", "audio/wav/path": tmp_path / "none.wav"})
    done = subprocess.run(NODE, env=master, capture_output=True, text=True, timeout=PATIENCE)
    assert done.returncode == 2
    said = (done.stdout + done.stderr).splitlines()
    assert len([line for line in said if "none.wav: no such file" in line]) == 1
    assert not any("Traceback" in line for line in said)


def test_a_wrong_setting_ends_it_at_once_with_the_reason(master):
    load(master, {"audio/vad/detector": "magic"})
    done = subprocess.run(NODE, env=master, capture_output=True, text=True, timeout=PATIENCE)
    assert done.returncode == 2
    words = "audio.vad.detector is 'magic', allowed: one of silero, energy, either"
    assert words in done.stdout + done.stderr

# SPDX-License-Identifier: BSD-3-Clause
"""A voice node that cannot keep up is recorded, and the recording is heard again.

The controller is a stub that answers, so that nothing but the sound moves the session on.
"""

import json
import signal
import subprocess
import sys
from contextlib import closing, contextmanager
from pathlib import Path

import soundfile
import yaml

from demo.script import load_script
from demo.sound import render
from session_log.mcap_file.decoder import Decoder
from session_log.mcap_file.reader import SessionReader
from support.theatre_sound import RATE
from support.waiting import PATIENCE, wait_until
from tests.support.ros_host import Host

ROOT = Path(__file__).resolve().parents[2]
PROGRAMS = Path(__file__).parent / "programs"
PACKAGES = ROOT / "catkin_ws" / "src"
SCRIPT = ROOT / "tests" / "data" / "replay_session.yaml"
SPOKEN = 280.0  # [s] allowed for a busy machine to hear all of it
QUEUE = 10_000  # frames: no sound is lost on a slower machine
ANSWERED = 30.0  # [s] allowed for an answer there
LAST = "terminate"
UTTERANCE, CIRCUMSTANCES = "/voice_assist/utterance", "/voice_assist/circumstances"


def settings(folder, **changes):
    """Parameters of both nodes."""
    names = ("audio", "recognizer", "spotter", "commands", "moving")
    read = {
        n: yaml.safe_load((PACKAGES / "voice_assist/config" / f"{n}.yaml").read_text())
        for n in names
    }
    read["audio"]["source"] = "wav"
    read["audio"]["wav"]["path"] = str(folder / "said.wav")
    for path, value in changes.items():
        *parents, key = path.split("__")
        branch = read
        for parent in parents:
            branch = branch[parent]
        branch[key] = value
    recorder = yaml.safe_load((PACKAGES / "session_log/config/recorder.yaml").read_text())
    return {"voice_assist": read, "recorder": {**recorder, "folder": str(folder), "name": "s"}}


@contextmanager
def running(words, environment):
    process = subprocess.Popen(words, env=environment)
    try:
        yield process
    finally:
        process.send_signal(signal.SIGINT)
        try:
            process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def contents(path, topic):
    decoder = Decoder()
    return [decoder.decode(m) for m in SessionReader(path).messages({topic})]


def answers(path):
    """Commands that were answered, and whether they were accepted."""
    notes = [json.loads(m.data) for m in contents(path, CIRCUMSTANCES)]
    return {n["command"]: n["is_accepted"] for n in notes if n["kind"] == "answered"}


def has_ended(path):
    """The last words were heard, and the controller answered them."""
    return LAST in answers(path) and any(m.transcript == LAST for m in contents(path, UTTERANCE))


def record(folder, **changes):
    """One session: what the script says, heard by the node and recorded."""
    soundfile.write(folder / "said.wav", render(load_script(SCRIPT), 1.0), RATE, subtype="PCM_16")
    path = folder / "s" / "session.mcap"
    with closing(Host(folder)) as host:
        host.start_master()
        environment = host.environment
        for node, given in settings(folder, **changes).items():
            host.master.setParam(f"/{node}", given)
        recorder = [
            sys.executable,
            str(PACKAGES / "session_log/scripts/recorder"),
            "__name:=recorder",
        ]
        voice = [
            sys.executable,
            str(PACKAGES / "voice_assist/scripts/voice"),
            "__name:=voice_assist",
        ]
        stub = [sys.executable, str(PROGRAMS / "controller_stub.py"), str(folder / "stub_ready")]
        with running(recorder, environment):
            wait_until(path.exists, "the recording")
            with running(stub, environment):
                wait_until((folder / "stub_ready").exists, "the controller's stub")
                with running(voice, environment):
                    wait_until(lambda: has_ended(path), repr(LAST), SPOKEN, every=1.0)
    return path


def run_replay(path, out):
    words = [sys.executable, "-m", "session_log.cli", "replay", str(path), "--json", str(out)]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=False)
    return done.returncode, done.stdout + done.stderr, json.loads(out.read_text())


def test_a_node_that_could_not_keep_up_is_heard_again_without_a_difference(tmp_path):
    """Sound comes three times too fast: looks are skipped."""
    changes = {"audio__wav__speed": 3.0, "recognizer__early__max_backlog": 0.0}
    patient = {"audio__queue": QUEUE, "commands__answer_within": ANSWERED}
    path = record(tmp_path, **changes, **patient)
    kinds = {json.loads(m.data)["kind"] for m in contents(path, CIRCUMSTANCES)}
    assert "behind" in kinds, "the node kept up, so nothing is shown"
    answered = answers(path)
    assert answered == {command: command != "tense" for command in answered}
    code, shown, result = run_replay(path, tmp_path / "r.json")
    assert code == 0 and result["sessions"][0]["recorded"] > 3, shown
    assert result["sessions"][0]["differences"] == []

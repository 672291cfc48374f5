# SPDX-License-Identifier: BSD-3-Clause
"""From a sound file to a moved robot to an MCAP file, through the whole launched system."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from mcap.reader import make_reader
from mcap_ros1.decoder import DecoderFactory

from demo.check import REST

ROOT = Path(__file__).resolve().parents[2]
SCRIPT = ROOT / "tests" / "data" / "short_session.yaml"
COMMAND = [sys.executable, "-m", "demo", "--wav", "--script", str(SCRIPT)]


def messages(mcap, *topics):
    """Yield (topic, message) of a recording, by the public readers alone."""
    with mcap.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        for _, channel, _, message in reader.iter_decoded_messages(topics=list(topics) or None):
            yield channel.topic, message


@pytest.fixture(scope="module")
def session(tmp_path_factory):
    folder = tmp_path_factory.mktemp("session")
    done = subprocess.run(
        [*COMMAND, "--out", str(folder)],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=200.0,
        check=False,
    )
    return folder, done.stdout + done.stderr


def test_the_session_leaves_a_recording_and_a_report(session):
    folder, shown = session
    assert (folder / "session.mcap").is_file(), shown
    assert (folder / "report.html").is_file(), shown


def test_the_words_reached_the_robot_and_the_talk_did_not(session):
    folder, shown = session
    taken = [
        message.command
        for _, message in messages(folder / "session.mcap", "/voice_assist/utterance")
        if message.command
    ]
    assert taken == ["hey robot", "tense", "stop"], shown


def test_the_robot_moved_through_the_trocar_and_stopped_in_mid_motion(session):
    folder, shown = session
    states = [m for _, m in messages(folder / "session.mcap", "/rst_control/state")]
    moving = [s for s in states if abs(s.path_speed) > REST]
    assert moving, shown
    assert max(s.rcm_error for s in moving) < 1e-3
    assert states[-1].halted and abs(states[-1].path_speed) < REST
    assert not states[-1].tissue_held, "it was stopped on its way to the tissue"


def test_the_recording_holds_sound_joint_states_and_decisions(session):
    folder, _ = session
    counts = {}
    for topic, _ in messages(folder / "session.mcap"):
        counts[topic] = counts.get(topic, 0) + 1
    assert counts["/voice_assist/audio"] > 10 * 16_000 / 512
    assert counts["/joint_states"] > 10 * 100
    assert {"/rst_control/event", "/rst_control/trocar", "/robot/tension"} <= set(counts)


def _heed_ctrl_c():
    """Tests that a shell runs in the background inherit that SIGINT is ignored."""
    signal.signal(signal.SIGINT, signal.default_int_handler)


def test_ctrl_c_ends_everything_and_leaves_a_readable_recording(tmp_path):
    demo = subprocess.Popen(
        [*COMMAND, "--out", str(tmp_path)],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        text=True,
        preexec_fn=_heed_ctrl_c,
    )
    mcap = tmp_path / "session.mcap"
    deadline = time.monotonic() + 90.0
    while not (mcap.is_file() and mcap.stat().st_size > 100_000):
        assert time.monotonic() < deadline and demo.poll() is None
        time.sleep(0.2)
    demo.send_signal(signal.SIGINT)
    shown, _ = demo.communicate(timeout=60.0)
    assert demo.returncode == 130, shown
    assert any(True for _ in messages(mcap, "/joint_states"))
    log = str(tmp_path / "ros_logs")
    for process in Path("/proc").glob("[0-9]*"):
        try:
            environment = (process / "environ").read_bytes()
        except OSError:
            continue
        if int(process.name) != os.getpid():
            assert log.encode() not in environment, f"process {process.name} was left running"

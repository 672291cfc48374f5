# SPDX-License-Identifier: BSD-3-Clause
"""The recorder as a process of its own, with its own roscore and a second process that talks."""

import hashlib
import json
import os
import signal
import subprocess
import sys
import time
from contextlib import closing, contextmanager
from datetime import datetime
from pathlib import Path

import pytest
import yaml
from mcap.reader import make_reader
from mcap_ros1.decoder import DecoderFactory

from session_log.mcap_file.reader import SessionReader
from session_log.mcap_file.summary import read_summary
from session_log.recording import metadata
from support.waiting import PATIENCE, wait_until
from tests.integration.programs import interrupted_recorder, recorder_talker
from tests.integration.programs.recorder_talker import FAST, odd_classes, odd_message
from tests.support.ros_host import Host
from typed_config import load_yaml

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "catkin_ws" / "src" / "session_log"


class Ros(Host):
    """A host whose processes see ROS as an installed package would."""

    def __init__(self, folder):
        super().__init__(folder)
        self.environment |= {
            "ROS_PACKAGE_PATH": os.pathsep.join(
                [str(ROOT / "catkin_ws" / "src"), os.environ.get("ROS_PACKAGE_PATH", "/usr/share")]
            ),
            "PYTHONPATH": os.pathsep.join(sys.path),
            "PATH": os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]]),
        }


@pytest.fixture(scope="module")
def ros(tmp_path_factory):
    ros = Ros(tmp_path_factory.mktemp("ros"))
    ros.start_master()
    yield ros
    ros.close()


@contextmanager
def recorder(ros, folder, screen=None, program=(PACKAGE / "scripts" / "recorder",), **changes):
    settings = dict(load_yaml(PACKAGE / "config" / "recorder.yaml"))
    settings |= {"folder": str(folder), "name": ".", **changes}
    ros.master.setParam("/recorder", settings)
    streams = {"stderr": screen.open("wb")} if screen else {}
    process = ros.start(sys.executable, *map(str, program), **streams)
    try:
        yield process
    finally:
        if process.poll() is None:
            process.send_signal(signal.SIGINT)
            process.wait(PATIENCE)
        ros.master.deleteParam("/recorder")


def talk(ros, *words):
    """Start the process that talks; returns it with its output as a pipe."""
    command = [sys.executable, recorder_talker.__file__, *words]
    return ros.start(*command, stdout=subprocess.PIPE, text=True)


def lines(process):
    out, _ = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0
    return [json.loads(line) for line in out.splitlines() if line.startswith("{")]


@pytest.fixture(scope="module")
def session(ros, tmp_path_factory):
    """A recording of fast topics, a latched one from before, and one that appears late."""
    folder = tmp_path_factory.mktemp("session")
    ros.master.setParam("/robot_description", "<robot name='test'/>")
    model = folder / "model.pt"
    model.write_bytes(b"weights")
    ros.master.setParam("/session/voice_assist", {"model": str(model)})
    process = talk(ros, "traffic", "1500")
    wait_until(lambda: any(t == "/latched" for t, _ in ros.master.getPublishedTopics("")), "talk")
    with recorder(ros, folder, seed=11):
        (said,) = lines(process)
    return folder / "session.mcap", said


def test_everything_published_while_connected_is_recorded(session):
    path, said = session
    result = read_summary(SessionReader(path))
    assert (result.condition.is_closed, result.condition.checksum) == (True, "good")
    for topic in FAST:
        assert result.topics[topic].messages == said["published"] == 1500
    assert result.missing == 0 and not result.condition.latest("losses")


def test_a_latched_message_from_before_the_recorder_is_there(session):
    (message,) = SessionReader(session[0]).messages({"/latched"})
    assert message.source.is_latched and message.data.endswith(b"said once, long ago")


def test_a_topic_that_appears_late_is_found(session):
    result = read_summary(SessionReader(session[0]))
    assert result.topics["/late"].messages >= 1


def test_the_bytes_are_those_of_ros_and_its_own_classes_read_them(session):
    from sensor_msgs.msg import JointState

    with session[0].open("rb") as file:
        for k, (schema, channel, message) in enumerate(
            make_reader(file).iter_messages(["/joint_states"])
        ):
            found = JointState()
            found.deserialize(message.data)
            assert found.position[0] == float(k) and found.name[6] == "joint_7"
            if k == 0:
                assert schema.data.decode().strip() == JointState._full_text.strip()
                assert channel.metadata["md5sum"] == JointState._md5sum


def test_settings_model_and_robot_are_recorded_with_it(session):
    reader = SessionReader(session[0])
    (urdf,) = reader.messages({"/robot_description"})
    assert urdf.data[4:] == b"<robot name='test'/>"
    condition = reader.condition
    model = session[0].with_name("model.pt")
    facts = {"model": str(model), "model_sha256": hashlib.sha256(b"weights").hexdigest()}
    assert condition.latest("session/voice_assist") == facts
    parameters = condition.latest("parameters")
    assert yaml.safe_load(parameters["recorder"])["flush_period"] == 0.05
    assert "robot_description" not in parameters
    head = subprocess.run(["git", "rev-parse", "HEAD"], cwd=ROOT, capture_output=True, text=True)
    assert condition.latest("code")["commit"] == (head.stdout.strip() or "unknown")
    assert condition.latest("machine") == metadata.machine_facts()
    assert condition.latest("versions") == metadata.version_facts()
    assert condition.latest("session")["seed"] == "11"
    started = datetime.fromisoformat(condition.latest("session")["started"])
    assert 0.0 < time.time() - started.timestamp() < 3600.0


def test_a_type_that_this_workspace_does_not_have_is_recorded_by_its_definition(session):
    kind = odd_classes()["strange_msgs/Odd"]
    with session[0].open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        ((schema, channel, _, odd),) = reader.iter_decoded_messages(["/odd"])
    assert (schema.name, channel.metadata["md5sum"]) == ("strange_msgs/Odd", kind._md5sum)
    assert [(p.name, list(p.samples)) for p in odd.parts] == [("a", [1.5]), ("", []), ("ü", [2, 3])]
    assert (odd.when.secs, odd.when.nsecs, odd.lasting.secs, odd.lasting.nsecs) == (7, 8, -9, 10)
    assert (list(odd.fixed), list(odd.words), bytes(odd.raw)) == (
        [-1, 2, 3],
        ["", "x y"],
        b"\0\xff",
    )
    assert odd.LIMIT == 5 and odd.is_true and odd.large == 2**63 + 1
    found = kind()
    (message,) = SessionReader(session[0]).messages({"/odd"})
    found.deserialize(message.data)  # by a class of genpy, as ROS itself reads it
    assert found == odd_message()


def test_a_recording_is_played_for_viewers_that_open_no_files(ros, session):
    listener = talk(ros, "listen", "/played")
    wait_until(listener.stdout.readline, "the listener")
    play = [sys.executable, str(PACKAGE / "scripts" / "play"), str(session[0])]
    player = ros.start(*play, "--rate", "2", stdout=subprocess.DEVNULL)
    (heard,) = lines(listener)
    assert heard["joints"] == [float(k) for k in range(1500)]
    assert (heard["name"], heard["odd"]) == ("joint_7", True)
    assert heard["urdf"] == "<robot name='test'/>"
    assert player.wait(PATIENCE) == 0


def require_refusal(ros, session):
    """Under the recorded names it is not played, and the refusal names topic and node."""
    play = [sys.executable, str(PACKAGE / "scripts" / "play"), str(session[0])]
    refused = ros.start(*play, "--recorded-names", stderr=subprocess.PIPE, text=True)
    assert "/joint_states by /talker" in refused.communicate(timeout=PATIENCE)[1]
    assert refused.returncode == 1


def test_a_recording_is_not_played_to_those_who_only_listen(ros, session):
    """The controller hears joint states that nobody publishes yet."""
    listener = talk(ros, "listen", "")
    wait_until(listener.stdout.readline, "the listener")
    require_refusal(ros, session)
    listener.kill()
    listener.wait(PATIENCE)


def test_a_recording_is_not_played_into_a_running_system(ros, session):
    robot = talk(ros, "until_killed")
    wait_until(lambda: ["/joint_states", "sensor_msgs/JointState"] in topics(ros), "the robot")
    require_refusal(ros, session)
    robot.kill()
    robot.wait(PATIENCE)


def topics(ros):
    return ros.master.getPublishedTopics("")


def test_sigkill_takes_nothing_that_was_acknowledged(ros, tmp_path):
    with recorder(ros, tmp_path) as process:
        talker = talk(ros, "until_killed")
        acknowledged = 0
        for line in talker.stdout:
            acknowledged = json.loads(line)["acknowledged"]
            if acknowledged > 600:
                break
        process.send_signal(signal.SIGKILL)
        process.wait(PATIENCE)
        talker.kill()
        rest = talker.stdout.read().splitlines()[:-1]
        talker.wait(PATIENCE)
    acknowledged = max([acknowledged, *(json.loads(line)["acknowledged"] for line in rest)])
    result = read_summary(SessionReader(tmp_path))
    assert not result.condition.is_closed
    assert result.topics["/joint_states"].messages >= acknowledged > 600
    assert result.missing == 0


def diagnosed(watcher):
    """What diagnostics say next; None where the next line is a heartbeat that has changed."""
    line = json.loads(watcher.stdout.readline())
    return None if line["level"] is None else line


def refused(watcher):
    """The same, once they say that nothing can be recorded, and the heartbeat says so as well."""
    found = diagnosed(watcher)
    is_said = found and "cannot record to" in found["message"]
    return found if is_said and found["message"] == f"NOT RECORDING: {found['heartbeat']}" else None


def test_a_folder_that_cannot_be_written_is_an_error_until_it_can(ros, tmp_path):
    obstacle = tmp_path / "sessions"
    obstacle.write_text("a file where the folder should be")
    with recorder(ros, obstacle, screen=tmp_path / "screen") as process:
        watcher = talk(ros, "watch")
        first = wait_until(lambda: refused(watcher), "the same error both ways")
        assert first["level"] == 2 and first["file"] == ""
        obstacle.unlink()
        found = first
        deadline = time.monotonic() + PATIENCE
        while (found["level"], found["heartbeat"]) != (0, "") and time.monotonic() < deadline:
            found = diagnosed(watcher) or found
        assert found["message"] == "recording" and found["heartbeat"] == ""
        process.send_signal(signal.SIGINT)
        process.wait(PATIENCE)
        end = wait_until(lambda: json.loads(watcher.stdout.readline())["heartbeat"], "the end")
        assert end == "the recorder was shut down"
        watcher.kill()
        watcher.wait(PATIENCE)
    assert "NOT RECORDING: cannot record to" in (tmp_path / "screen").read_text()
    assert read_summary(SessionReader(obstacle)).topics["/rosout"].messages > 0


def test_it_closes_the_file_whatever_it_does_when_it_is_interrupted(ros, tmp_path):
    with recorder(ros, tmp_path, program=(interrupted_recorder.__file__, tmp_path)) as process:
        assert process.wait(PATIENCE) == 0
    assert (tmp_path / interrupted_recorder.DONE).exists()
    assert read_summary(SessionReader(tmp_path)).condition.is_closed


def test_ctrl_c_closes_the_file_though_the_master_hangs(tmp_path):
    ros = Ros(tmp_path)
    ros.start_master()
    master = ros.master.getPid()
    with closing(ros), recorder(ros, tmp_path) as process:
        talker = talk(ros, "until_killed")
        wait_until(lambda: json.loads(talker.stdout.readline())["acknowledged"], "a message")
        os.kill(master, signal.SIGSTOP)
        try:
            process.send_signal(signal.SIGINT)
            assert process.wait(PATIENCE) == 0
        finally:
            os.kill(master, signal.SIGCONT)
    assert f"messages in {tmp_path / 'session.mcap'}" in ros.said()
    summary = read_summary(SessionReader(tmp_path))
    assert summary.condition.is_closed and summary.topics["/joint_states"].messages > 0


def test_a_wrong_setting_is_named_and_ends_the_node(ros, tmp_path):
    with recorder(ros, tmp_path, flush_perod=1.0) as process:
        assert process.wait(PATIENCE) == 2
    assert not (tmp_path / "session.mcap").exists()


def test_the_launch_file_records_into_the_folder_it_is_given(ros, tmp_path):
    folder = tmp_path / "mine"
    launch = ros.start(
        *("roslaunch", "--wait", str(ROOT / "launch" / "record.launch"), f"folder:={folder}"),
        stdout=subprocess.DEVNULL,
    )
    try:
        wait_until((folder / "session.mcap").exists, "the recording")
        time.sleep(1.0)
    finally:
        launch.send_signal(signal.SIGINT)
        launch.wait(PATIENCE)
    condition = read_summary(SessionReader(folder)).condition
    assert condition.is_closed and condition.checksum == "good"

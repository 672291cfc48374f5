# SPDX-License-Identifier: BSD-3-Clause
"""The recorder as a process of its own, with its own roscore and a second process that talks."""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path

import pytest
import rosgraph
from mcap.reader import make_reader

from session_log.reader import SessionReader
from session_log.survey import survey
from typed_config import load_yaml

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "catkin_ws" / "src" / "session_log"
PATIENCE = 40.0  # [s] after which a test gives up
FAST = ("/joint_states", "/robot/servo_jp", "/robot/tension")


def wait_until(claim, what):
    deadline = time.monotonic() + PATIENCE
    while not (found := claim()):
        assert time.monotonic() < deadline, f"never: {what}"
        time.sleep(0.05)
    return found


class Ros:
    """A roscore on a free port of the loopback."""

    def __init__(self, folder):
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            port = probe.getsockname()[1]
        self.uri = f"http://127.0.0.1:{port}"
        self.environment = {
            **os.environ,
            "ROS_IP": "127.0.0.1",
            "ROS_MASTER_URI": self.uri,
            "ROS_HOME": str(folder / "ros"),
            "ROS_LOG_DIR": str(folder / "ros" / "log"),
            "ROS_PACKAGE_PATH": os.pathsep.join(
                [str(ROOT / "catkin_ws" / "src"), os.environ.get("ROS_PACKAGE_PATH", "/usr/share")]
            ),
            "PYTHONPATH": os.pathsep.join(sys.path),
            "PATH": os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]]),
        }
        self.master = rosgraph.Master("/test", master_uri=self.uri)
        self._children = []
        self._core = self.start(["roscore", "-p", str(port)], stdout=subprocess.DEVNULL)
        wait_until(self.master.is_online, "roscore answers")

    def start(self, command, **options):
        process = subprocess.Popen(command, env=self.environment, cwd=ROOT, **options)
        self._children.append(process)
        return process

    def close(self):
        for process in self._children[1:]:
            process.kill()  # only those that a failed test left
            process.wait(PATIENCE)
        self._core.send_signal(signal.SIGINT)
        self._core.wait(PATIENCE)


@pytest.fixture(scope="module")
def ros(tmp_path_factory):
    ros = Ros(tmp_path_factory.mktemp("ros"))
    yield ros
    ros.close()


@contextmanager
def recorder(ros, folder, **changes):
    settings = dict(load_yaml(PACKAGE / "config" / "recorder.yaml"))
    settings |= {"folder": str(folder), "name": ".", **changes}
    ros.master.setParam("/recorder", settings)
    process = ros.start([sys.executable, str(PACKAGE / "scripts" / "recorder")])
    try:
        yield process
    finally:
        if process.poll() is None:
            process.send_signal(signal.SIGINT)
            process.wait(PATIENCE)
        ros.master.deleteParam("/recorder")


def talk(ros, *words):
    """Run this file as the process that talks; returns it with its output as a pipe."""
    command = [sys.executable, __file__, *words]
    return ros.start(command, stdout=subprocess.PIPE, text=True)


def lines(process):
    out, _ = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0
    return [json.loads(line) for line in out.splitlines() if line.startswith("{")]


@pytest.fixture(scope="module")
def session(ros, tmp_path_factory):
    """A recording of fast topics, a latched one from before, and one that appears late."""
    folder = tmp_path_factory.mktemp("session")
    ros.master.setParam("/robot_description", "<robot name='test'/>")
    ros.master.setParam("/session/voice_assist", {"model": "embedded", "seed": 3})
    process = talk(ros, "traffic", "1500")
    wait_until(lambda: any(t == "/latched" for t, _ in ros.master.getPublishedTopics("")), "talk")
    with recorder(ros, folder):
        (said,) = lines(process)
    return folder / "session.mcap", said


def test_everything_published_while_connected_is_recorded(session):
    path, said = session
    result = survey(SessionReader(path))
    assert (result.condition.is_closed, result.condition.checksum) == (True, "good")
    for topic in FAST:
        assert result.topics[topic].messages == said["published"] == 1500
    assert result.missing == 0 and not result.condition.latest("losses")


def test_a_latched_message_from_before_the_recorder_is_there(session):
    (message,) = SessionReader(session[0]).messages({"/latched"})
    assert message.source.is_latched and message.data.endswith(b"said once, long ago")


def test_a_topic_that_appears_late_is_found(session):
    result = survey(SessionReader(session[0]))
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
    assert condition.latest("session/voice_assist") == {"model": "embedded", "seed": "3"}
    assert "flush_period" in condition.latest("parameters")["recorder"]
    assert condition.latest("code")["commit"] and condition.latest("versions")["mcap"]


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
    result = survey(SessionReader(tmp_path))
    assert not result.condition.is_closed
    assert result.topics["/joint_states"].messages >= acknowledged > 600
    assert result.missing == 0


def test_a_folder_that_cannot_be_written_is_an_error_until_it_can(ros, tmp_path):
    obstacle = tmp_path / "sessions"
    obstacle.write_text("a file where the folder should be")
    with recorder(ros, obstacle):
        watcher = talk(ros, "watch")
        first = json.loads(wait_until(watcher.stdout.readline, "diagnostics"))
        assert first["level"] == 2 and "NOT RECORDING" in first["message"]
        assert "cannot record to" in first["message"] and first["file"] == ""
        obstacle.unlink()
        found = first
        deadline = time.monotonic() + PATIENCE
        while found["level"] != 0 and time.monotonic() < deadline:
            found = json.loads(watcher.stdout.readline())
        assert found["message"] == "recording"
        watcher.kill()
        watcher.wait(PATIENCE)
    assert survey(SessionReader(obstacle)).topics["/rosout"].messages > 0


def test_a_wrong_setting_is_named_and_ends_the_node(ros, tmp_path):
    with recorder(ros, tmp_path, flush_perod=1.0) as process:
        assert process.wait(PATIENCE) == 1
    assert not (tmp_path / "session.mcap").exists()


def test_the_launch_file_records_into_the_folder_it_is_given(ros, tmp_path):
    folder = tmp_path / "mine"
    launch = ros.start(
        ["roslaunch", "--wait", str(ROOT / "launch" / "record.launch"), f"folder:={folder}"],
        stdout=subprocess.DEVNULL,
    )
    try:
        wait_until((folder / "session.mcap").exists, "the recording")
        time.sleep(1.0)
    finally:
        launch.send_signal(signal.SIGINT)
        launch.wait(PATIENCE)
    condition = SessionReader(folder).check()
    assert condition.is_closed and condition.checksum == "good"


def say(**values):
    print(json.dumps(values), flush=True)


class Talker:
    """Publishes what the system would."""

    def __init__(self):
        import rospy
        from geometry_msgs.msg import WrenchStamped
        from sensor_msgs.msg import JointState

        names = [f"joint_{i}" for i in range(1, 8)]
        self.joints = JointState(name=names, position=[0.0] * 7, velocity=[0.0] * 7)
        self.wrench = WrenchStamped()
        kinds = (JointState, JointState, WrenchStamped)
        pairs = zip(FAST, kinds, strict=True)
        self.out = [rospy.Publisher(t, kind, queue_size=2000) for t, kind in pairs]
        self.count = 0
        while not all(p.get_num_connections() for p in self.out) and not rospy.is_shutdown():
            rospy.sleep(0.05)

    def publish(self):
        self.joints.position[0] = float(self.count)
        for publisher, message in zip(
            self.out, (self.joints, self.joints, self.wrench), strict=True
        ):
            publisher.publish(message)
        self.count += 1


def traffic(count):
    import rospy
    from std_msgs.msg import Empty, String

    latched = rospy.Publisher("/latched", String, latch=True, queue_size=1)
    latched.publish("said once, long ago")
    talker = Talker()
    rate = rospy.Rate(500)
    late = None
    for k in range(count):
        talker.publish()
        if k == count // 2:
            late = rospy.Publisher("/late", Empty, latch=True, queue_size=1)
            late.publish()
        rate.sleep()
    rospy.sleep(1.5)
    say(published=talker.count, late=late is not None)


def until_killed():
    import rospy
    from std_msgs.msg import Time

    stamps = []

    def acknowledge(message):
        # the stamp is taken before the message leaves, so what left two seconds before the
        # acknowledged time had arrived by then
        until = message.data.to_sec() - 2.0
        say(acknowledged=sum(stamp < until for stamp in list(stamps)))

    rospy.Subscriber("/session_log/written", Time, acknowledge)
    talker = Talker()
    rate = rospy.Rate(500)
    while not rospy.is_shutdown():
        stamps.append(time.time())
        talker.publish()
        rate.sleep()


def watch():
    import rospy
    from diagnostic_msgs.msg import DiagnosticArray
    from std_msgs.msg import String

    file = [""]
    rospy.Subscriber("/session_log/file", String, lambda m: file.__setitem__(0, m.data))
    rospy.sleep(1.0)

    def show(array):
        for status in array.status:
            if status.name == "recorder: recording":
                level = status.level[0] if isinstance(status.level, bytes) else status.level
                say(level=level, message=status.message, file=file[0])

    rospy.Subscriber("/diagnostics", DiagnosticArray, show)
    rospy.spin()


def main(words):
    import rospy

    rospy.init_node("talker", anonymous=True)
    if words[0] == "traffic":
        traffic(int(words[1]))
    elif words[0] == "until_killed":
        until_killed()
    else:
        watch()


if __name__ == "__main__":
    main(sys.argv[1:])

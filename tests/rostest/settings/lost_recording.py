#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The recorder is killed in mid-motion and started again; then its disk is full for a while."""

import resource
import signal
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import rospy
from diagnostic_msgs.msg import DiagnosticArray

from session_log.mcap_file.reader import SessionReader
from session_log.mcap_file.summary import read_summary
from support.waiting import PATIENCE
from tests.support.robot_client import RobotClient, run_tests
from typed_config import load_yaml

PACKAGE = Path(__file__).resolve().parents[3] / "catkin_ws" / "src" / "session_log"
ROOM = 600_000  # [B] more than the logs of a node, and a second of the session
EASING = ("release", "pull less", "withdraw", "stop")


IS_RECORDED = "recorded"  # "not recorded" holds the word too


class Recorder:
    """The recorder node as a process that the test may kill."""

    def __init__(self, test, folder):
        settings = dict(load_yaml(PACKAGE / "config" / "recorder.yaml"))
        rospy.set_param("/recorder", {**settings, "folder": str(folder), "name": "."})
        self._process = subprocess.Popen([sys.executable, PACKAGE / "scripts" / "recorder"])
        test.addCleanup(self.kill)  # also where the test fails; a second time does nothing

    def kill(self):
        self._process.kill()
        self._process.wait(PATIENCE)

    def end(self):
        self._process.send_signal(signal.SIGINT)
        self._process.wait(PATIENCE)

    def limit(self, size):
        """Let the system take files up to a size [B] only, as a disk that is full from there on."""
        resource.prlimit(self._process.pid, resource.RLIMIT_FSIZE, (size, resource.RLIM_INFINITY))


def is_said(status, words):
    """All of the words, and not their opposite."""
    return status == IS_RECORDED if words == (IS_RECORDED,) else all(w in status for w in words)


class LostRecording(unittest.TestCase):
    """A motion under way is finished; what loads the patient is refused until there is a record."""

    @classmethod
    def setUpClass(cls):
        cls.statuses = {}
        rospy.Subscriber("/diagnostics", DiagnosticArray, cls.note)
        cls.robot = RobotClient()

    @classmethod
    def note(cls, array):
        cls.statuses.update({s.name: s.message for s in array.status})

    def wait_for_status(self, name, *words):
        try:
            self.robot.wait(lambda: is_said(self.statuses.get(name, ""), words))
        except AssertionError:
            self.fail(f"{name} says {self.statuses.get(name)!r}, expected {words}")

    def assert_only_easing(self, reason):
        """Refused by name: what advances. Allowed: stop, and what eases."""
        refusal = self.robot.refused("tense")
        self.assertRegex(refusal, f"^not recorded: .*{reason}")
        for words in EASING:
            self.assertIn(f'"{words}"', refusal)
        self.robot.wait(lambda: self.robot.state.last_refusal == refusal)

    def test_1_before_any_recorder_nothing_sets_off(self):
        self.robot.activate()
        self.assert_only_easing("no recorder was ever heard; start launch/record.launch")
        self.robot.say("stop")
        self.robot.wait_for_state("halted")

    def test_2_killed_in_mid_motion_and_started_again(self):
        with tempfile.TemporaryDirectory() as folder:
            recorder = Recorder(self, Path(folder) / "first")
            self.wait_for_status("rst_control: recording", IS_RECORDED)
            self.robot.start_fresh()
            count = self.robot.finished("tense")
            self.robot.say("tense")
            self.robot.wait_for_motion()
            recorder.kill()
            self.robot.wait(lambda: self.robot.finished("tense") > count)
            self.assertTrue(self.robot.state.tissue_held)
            self.wait_for_status("rst_control: recording", "not recorded", "recorder silent for")
            self.assertRegex(self.robot.refused("pull more"), "^not recorded: .*recorder silent")
            tension = self.robot.tension
            self.robot.say_and_finish("pull less")
            self.assertLess(self.robot.tension, tension - 0.1)
            self.robot.say_and_finish("release")
            self.assert_only_easing("recorder silent for")
            self.robot.say("stop")
            self.robot.wait_for_state("halted")
            self.assertGreater(read_summary(SessionReader(Path(folder) / "first")).messages, 100)
            recorder = Recorder(self, Path(folder) / "second")
            self.wait_for_status("rst_control: recording", IS_RECORDED)
            self.robot.start_fresh()
            self.robot.say("tense")
            self.robot.say("stop")
            recorder.end()
            self.wait_for_status("rst_control: recording", "the recorder was shut down")

    def test_3_a_full_disk_is_named_and_forgotten_when_there_is_room(self):
        with tempfile.TemporaryDirectory() as folder:
            recorder = Recorder(self, folder)
            self.wait_for_status("rst_control: recording", IS_RECORDED)
            self.robot.start_fresh()
            recorder.limit(ROOM)
            self.wait_for_status("recorder: recording", "NOT RECORDING", "File too large")
            self.wait_for_status("rst_control: recording", "File too large")
            self.assert_only_easing("session.mcap: File too large")
            recorder.limit(resource.RLIM_INFINITY)
            self.robot.wait(lambda: "NOT" not in self.statuses.get("recorder: recording", "NOT"))
            self.wait_for_status("rst_control: recording", IS_RECORDED)
            self.robot.say_and_finish("tense")
            self.robot.say_and_finish("release")
            recorder.end()
            found = read_summary(SessionReader(folder))
            self.assertEqual(
                (found.missing, found.condition.damage, found.condition.checksum), (0, [], "good")
            )


if __name__ == "__main__":
    run_tests(LostRecording, "lost_recording")

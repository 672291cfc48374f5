#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The lines of the documentation, executed as they stand there against a running system."""

import os
import re
import shutil
import signal
import subprocess
import time
import unittest
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import rospy
from sensor_msgs.msg import JointState
from std_msgs.msg import String

from support.waiting import wait_until
from tests.support.doc_lines import all_lines, marker_of
from tests.support.robot_client import START_LIMIT, RobotClient, run_tests

ROOT = Path(__file__).resolve().parents[3]
SESSIONS = ROOT / ".cache" / "doc_examples"
A_SESSION = re.compile(r"^sessions/\S+$")
FEEDBACK = "/my_gen3/base_feedback/joint_state"
LIMIT = 90.0  # [s] for one line
RECORDED = 5.0  # [s] of the session that the lines are about, at least
RATE, RATES = "average rate", 3  # what one that runs until it is ended prints, and how often
ENDLESS = ("rostopic hz",)


def lines_of(system):
    """Lines that are executed against a system, page by page.

    What several pages have, of any session, is executed once.
    """
    found, pages = {}, {}
    for line in all_lines():
        marker = marker_of(line)
        if marker and marker.system == system:
            found.setdefault(tuple(A_SESSION.sub("a session", word) for word in line.words), line)
    for line in found.values():
        pages.setdefault(line.page, []).append(line)
    return list(pages.values())


class DocExamples(unittest.TestCase):
    """Every line of one system."""

    @classmethod
    def setUpClass(cls):
        cls.system = rospy.get_param("~system")
        cls.robot = RobotClient() if cls.system == "controller" else None
        if cls.system == "drivers":
            rospy.wait_for_message(FEEDBACK, JointState, START_LIMIT)
        if cls.system == "recording":
            rospy.wait_for_message("joint_states", JointState, START_LIMIT)
            files = []
            rospy.Subscriber("session_log/file", String, lambda m: files.append(m.data))
            wait_until(lambda: files and files[-1], "a recording")
            cls.session = Path(files[-1]).resolve().parent
            begun = cls.session.stat().st_mtime  # when the file was made in it
            rospy.sleep(max(0.0, begun + RECORDED - time.time()))

    @classmethod
    def tearDownClass(cls):
        if cls.robot:
            cls.robot.leave()
        if cls.system == "recording":
            shutil.rmtree(SESSIONS, ignore_errors=True)

    def test_every_line_does_what_its_page_says(self):
        pages = lines_of(self.system)
        self.assertTrue(pages)
        # pages that share a robot, or the files of a session, are followed one after the other
        at_once = len(pages) if self.system == "drivers" else 1
        with ThreadPoolExecutor(at_once) as pool:
            wrong = [words for found in pool.map(self.follow, pages) for words in found]
        self.assertEqual(wrong, [])

    def follow(self, lines):
        """Execute the lines of one page in their order; gives what went wrong."""
        wrong = []
        for line in lines:
            try:
                if self.robot:
                    self.robot.start_fresh()
                self.check(line, self.execute(line))
            except (AssertionError, subprocess.TimeoutExpired) as error:
                wrong.append(f"{line.page}:{line.number}: {line.text}: {error}")
        return wrong

    def execute(self, line):
        """Run a line in the repository; returns what it printed."""
        words = [self.place(word) for word in line.words]
        if not line.text.startswith(ENDLESS):
            done = subprocess.run(
                words, cwd=ROOT, capture_output=True, text=True, timeout=LIMIT, check=False
            )
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            return done.stdout
        unbuffered = {**os.environ, "PYTHONUNBUFFERED": "1"}
        running = subprocess.Popen(
            words, cwd=ROOT, stdout=subprocess.PIPE, text=True, env=unbuffered
        )
        printed = ""
        while printed.count(RATE) < RATES:
            line = running.stdout.readline()
            self.assertTrue(line, f"it ended: {printed}")
            printed += line
        running.send_signal(signal.SIGINT)
        return printed + running.communicate(timeout=LIMIT)[0]

    def place(self, word):
        """The session of this test in the place of the one that a page names."""
        return str(self.session) if A_SESSION.match(word) else word

    def check(self, line, printed):
        """What the page promises of the line."""
        if self.robot:
            self.assertIn("accepted: True", printed)
            self.assertEqual(self.robot.state.state, "active", self.robot.halts())
        elif "openrst_request" in line.text:
            self.assertIn("succeeded: True", printed)
        elif line.text.startswith("rostopic hz"):
            rates = [float(rate) for rate in re.findall(r"average rate: ([\d.]+)", printed)]
            self.assertAlmostEqual(rates[-1], 40.0, delta=15.0)
        else:
            self.assertTrue(printed.strip(), "it printed nothing")


if __name__ == "__main__":
    run_tests(DocExamples, "doc_examples")

# SPDX-License-Identifier: BSD-3-Clause
"""`rostest rst_control NAME.test` and `catkin_make run_tests` find each file and its scripts."""

import os
import re
from pathlib import Path
from types import SimpleNamespace
from xml.etree import ElementTree

import pytest
import roslib.packages
import rospkg

from tests.rostest.conftest import RosTest, RosTestError

FOLDER = Path(__file__).resolve().parents[1] / "rostest"
FILES = sorted(FOLDER.rglob("*.test"))
RUNS_TESTS = re.compile(r"^ +(run_tests|rostest\.rosrun)\(", re.MULTILINE)


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_each_file_and_its_scripts_are_found_by_their_names_alone(file):
    (found,) = roslib.packages.find_resource("rst_control", file.name)
    assert Path(found).samefile(file)
    assert rospkg.get_package_name(found) == "rst_control"
    for test in ElementTree.parse(file).getroot().iter("test"):
        assert len(roslib.packages.find_node("rst_control", test.get("type"))) == 1


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_each_file_finds_what_its_scripts_import_and_its_launch_files(file):
    """By the package: its folder is a link, and roslaunch goes up from the link's own place."""
    root = ElementTree.parse(file).getroot()
    (path,) = (env.get("value") for env in root.iter("env") if env.get("name") == "PYTHONPATH")
    assert path.startswith("$(find rst_control)/../../..:")
    assert all(i.get("file").startswith("$(find rst_control)/") for i in root.iter("include"))


def test_each_script_of_tests_is_run_by_a_file():
    scripts = {p.name for p in FOLDER.rglob("*.py") if RUNS_TESTS.search(p.read_text("utf-8"))}
    assert len(scripts) > 30
    tags = (tag for file in FILES for tag in ElementTree.parse(file).getroot().iter("test"))
    assert scripts == {tag.get("type") for tag in tags}


def run_script(tmp_path, text):
    """Let pytest's item of a script run this one, without a system."""
    item = object.__new__(RosTest)
    item.script, item.name, item.limit = tmp_path / "script.py", "script", 60.0
    item.script.write_text(text)
    system = SimpleNamespace(poll=lambda: None)
    host = SimpleNamespace(environment=dict(os.environ), said=lambda: "")
    item.parent = SimpleNamespace(system=system, host=host)
    item.runtest()


TESTS = """
import sys, unittest
class Tests(unittest.TestCase):
    def test_1(self):
        {0}
    def test_2(self):
        {1}
tests = unittest.TestLoader().loadTestsFromTestCase(Tests)
sys.exit(not unittest.TextTestRunner(verbosity=2).run(tests).wasSuccessful())
"""
SKIP, FAIL = "self.skipTest('no espeak-ng')", "self.fail('it moves')"


def test_a_script_that_skips_itself_or_a_test_is_shown_as_skipped(tmp_path):
    for text in ("print('skipped: no espeak-ng')", TESTS.format(SKIP, SKIP.replace("no", "of no"))):
        with pytest.raises(pytest.skip.Exception, match=r"^'?no espeak-ng'?$"):
            run_script(tmp_path, text)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("print('skipped: no browser'); raise SystemExit(3)", "ended with: 3"),
        (TESTS.format(SKIP, FAIL), "it moves"),
        ("print('Ran 0 tests in 0.000s')", "ended with: 0"),
        ("", "ended with: 0"),
    ],
)
def test_a_script_that_fails_or_runs_nothing_fails_whatever_it_skips(tmp_path, text, words):
    with pytest.raises((RosTestError, pytest.skip.Exception), match=words) as raised:
        run_script(tmp_path, text)
    assert raised.type is RosTestError


def test_a_script_whose_tests_all_run_well_passes(tmp_path):
    run_script(tmp_path, TESTS.format("pass", "pass"))

# SPDX-License-Identifier: BSD-3-Clause
"""A rostest is run again only where something shows that the machine did not keep up."""

import subprocess
import sys
import time
from pathlib import Path

import pytest
from standstill import LONG, Standstills, overtaken

ROOT = Path(__file__).resolve().parents[2]
REASONS = [
    "fault: set-points stopped coming while moving, 104 ms ago",
    "halted: joint states stale, 612 ms old, allowed 500 ms",
    "the bridge did not run for 0.21 s in motion, allowed 0.10 s",
    "joints of the arm 520 ms old, allowed 500 ms",
    "the stop guard is silent for 0.91 s, allowed 0.80 s",
    "joint_4 +0.151 rad off its set-point",
    "shaft 1.01 mm off the trocar, allowed 1.00",
]
OF_THE_PRODUCT = [
    "",
    "AssertionError: 'hey robot' was refused: unknown command",
    "set-points stopped coming",
    "tension 4.10 N, allowed 4.00 N",
]


@pytest.mark.parametrize("reason", REASONS)
def test_a_halt_that_lateness_brings_about_is_evidence(reason):
    assert overtaken(f"[WARN] {reason}\nFAIL", 0.0) in reason
    assert overtaken(f"[WARN] {reason}\nFAIL", 0.0)


@pytest.mark.parametrize("printed", OF_THE_PRODUCT)
def test_any_other_failure_is_not(printed):
    assert overtaken(printed, 0.9 * LONG) == ""


def test_a_long_standstill_is_evidence():
    assert overtaken("FAIL", 0.12) == "the machine stood still for 120 ms"


def test_a_thread_that_was_kept_from_running_is_noticed():
    class Late:
        """An event whose waiting takes longer than it was asked to, once."""

        def __init__(self):
            self.count = 0

        def wait(self, seconds):
            self.count += 1
            time.sleep(seconds + (0.15 if self.count == 2 else 0.0))
            return self.count == 3

        def set(self):
            pass

    with Standstills(Late()) as machine:
        time.sleep(0.3)
    assert machine.longest >= 0.15


FAKE = """
import conftest, pytest
from pathlib import Path

def once(self):
    runs = Path({runs!r})
    runs.write_text(runs.read_text() + "x" if runs.exists() else "x")
    if len(runs.read_text()) <= {failures}:
        raise conftest.RosTestError({printed!r}, {printed!r})

conftest.RosTest._run_on_a_master = once
from conftest import pytest_collect_file, pytest_terminal_summary
"""
STALE = "joint states stale, 612 ms old, allowed 500 ms"


@pytest.mark.parametrize(
    ("printed", "failures", "runs", "outcome"),
    [
        (STALE, 1, 2, "1 passed"),
        (STALE, 2, 2, "1 failed"),
        ("refused: unknown command", 1, 1, "1 failed"),
        ("", 0, 1, "1 passed"),
    ],
)
def test_it_is_run_again_once_and_said_so(tmp_path, printed, failures, runs, outcome):
    folder = tmp_path / "rostest"
    folder.mkdir()
    (folder / "some.test").write_text("<launch/>")
    (tmp_path / "plugin.py").write_text(
        FAKE.format(runs=str(tmp_path / "runs"), failures=failures, printed=printed)
        + "import standstill\nstandstill.LONG = 9.0  # this machine may be busy itself\n"
    )
    path = f"import sys; sys.path[:0] = [{str(tmp_path)!r}, {str(ROOT / 'tests')!r}, {str(ROOT)!r}]"
    script = f"{path}; import pytest; sys.exit(pytest.main(sys.argv[1:], plugins=[]))"
    done = subprocess.run(
        [sys.executable, "-c", script, "-p", "plugin", "-c", "/dev/null", str(folder)],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert outcome in done.stdout, done.stdout + done.stderr
    assert len((tmp_path / "runs").read_text()) == runs
    assert ("run again, since the machine" in done.stdout) == (runs == 2)

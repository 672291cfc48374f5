# SPDX-License-Identifier: BSD-3-Clause
"""What a verb of make runs does not take the addresses and names that the shell has for ROS."""

import os
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SHELL = {"ROS_HOSTNAME": "a.host.that.is.none", "ROS_NAMESPACE": "left", "PYTHONPATH": "/none"}


def test_a_host_name_and_a_namespace_of_the_shell_reach_no_verb():
    given = {**os.environ, **SHELL}
    words = ["make", "--no-print-directory", "--eval", "shown: ; @$(RUN) env", "shown"]
    done = subprocess.run(words, cwd=ROOT, env=given, capture_output=True, text=True, check=True)
    found = dict(line.split("=", 1) for line in done.stdout.splitlines() if "=" in line)
    assert "ROS_HOSTNAME" not in found and "ROS_NAMESPACE" not in found
    assert found["ROS_IP"] == "127.0.0.1"
    assert "/none" not in found["PYTHONPATH"].split(":")

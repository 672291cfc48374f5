# SPDX-License-Identifier: BSD-3-Clause
"""Processor time and memory by node, of processes that are really there."""

import os
import signal
import subprocess
import sys

import pytest

from bench.system.processes import ROS, Usage, between, usage
from support.waiting import wait_until

BURN = "held = bytearray(60_000_000)\nwhile True: pass"
RUN = "import subprocess, sys; subprocess.run([sys.executable, '-c', {!r}, {!r}])"
NODE = RUN.format(BURN, "")
LAUNCH = RUN.format(NODE, "__name:=robot")


@pytest.fixture
def launch():
    """A stand-in of roslaunch with a node that has a child of its own."""
    process = subprocess.Popen([sys.executable, "-c", LAUNCH], start_new_session=True)
    yield process.pid
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()


def test_a_node_is_all_that_descends_from_it_and_the_rest_is_of_ros(launch):
    first = wait_until(lambda: is_held(usage([launch])), "the memory")
    last = wait_until(lambda: is_later(first, usage([launch])), "some work")
    assert set(last) == {ROS, "robot"}
    assert last["robot"].memory > 60.0 > last[ROS].memory
    assert usage([]) == {}


def is_held(found):
    return found if found.get("robot", Usage()).memory > 60.0 else None


def is_later(first, found):
    return found if between(first, found)["robot"] > 0.0 else None


def test_a_node_that_was_not_there_before_has_no_time_between():
    assert between({"a": Usage(1.0)}, {"a": Usage(3.0), "b": Usage(5.0)}) == {"a": 2.0}

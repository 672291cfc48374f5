# SPDX-License-Identifier: BSD-3-Clause
"""A launch whose nodes run already on the master starts nothing, and changes no parameter there."""

import socket
import subprocess
import threading
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path
from xmlrpc.server import SimpleXMLRPCServer

import pytest

from support.launched_system import free_port
from support.waiting import PATIENCE
from typed_config.ros import xmlrpc
from typed_config.ros.running_nodes import running_again

LAUNCH = Path(__file__).resolve().parents[2] / "launch"
ALARMS, VOICE, PEDAL, SYSTEM = (
    LAUNCH / f"{name}.launch" for name in ("alarms", "voice", "pedal", "system")
)
RUNNING, SHARED = "/left/alarms", "/robot_state_publisher"
DEAD, TAKEN = "/voice_assist", "/pedal"
GROUP = '<launch><group ns="{ns}"><include file="{file}"/></group></launch>'


@pytest.fixture(scope="module")
def calls():
    """A master with a node that runs and two that were killed; all methods called, in order.

    The port of one of these was taken by a server that is no node.
    """
    server = SimpleXMLRPCServer(("127.0.0.1", 0), logRequests=False)
    other = HTTPServer(("127.0.0.1", 0), BaseHTTPRequestHandler)
    uri, seen = f"http://127.0.0.1:{server.server_address[1]}/", []
    dead = socket.socket()
    dead.bind(("127.0.0.1", 0))  # nobody listens there, and nobody else may
    uris = {RUNNING: uri, SHARED: uri, DEAD: f"http://127.0.0.1:{dead.getsockname()[1]}/"}
    uris[TAKEN] = f"http://127.0.0.1:{other.server_port}/"
    state = [[["/rosout", [RUNNING, DEAD, TAKEN, SHARED]]], [], []]
    answers = {"getSystemState": lambda *_: state, "lookupNode": lambda _, name: uris[name]}

    def answer(method, words):
        seen.append(method)
        return 1, "", answers.get(method, lambda *_: 1)(*words)

    server._dispatch = answer
    for one in (server, other):
        threading.Thread(target=one.serve_forever, daemon=True).start()
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ROS_MASTER_URI", uri)
        patch.setenv("ROS_IP", "127.0.0.1")
        patch.setattr(xmlrpc, "ANSWER_TIME", PATIENCE)
        patch.delenv("ROS_NAMESPACE", raising=False)
        yield seen
    dead.close()
    for one in (server, other):
        one.shutdown()
        one.server_close()


def again(file, *words):
    return running_again(file, ["/usr/bin/python3", "/usr/bin/roslaunch", *words])


def test_in_another_namespace_it_is_another_node(calls):
    assert again(ALARMS, str(ALARMS)) == []


@pytest.mark.parametrize("top", [ALARMS, SYSTEM])
def test_in_the_same_namespace_it_runs_already(calls, monkeypatch, top):
    monkeypatch.setenv("ROS_NAMESPACE", "left")
    assert again(ALARMS, str(top)) == [RUNNING]


@pytest.mark.parametrize(("ns", "found"), [("left", [RUNNING]), ("right", [])])
def test_the_namespace_of_a_group_in_a_file_of_the_users_counts(calls, tmp_path, ns, found):
    mine = tmp_path / "mine.launch"
    mine.write_text(GROUP.format(ns=ns, file=ALARMS))
    assert again(ALARMS, str(mine)) == found


@pytest.mark.parametrize("file", [VOICE, PEDAL])
def test_a_node_that_was_killed_does_not_run(calls, file):
    assert again(file, str(file)) == []


def test_what_starts_nothing_is_not_refused(calls, monkeypatch):
    monkeypatch.setenv("ROS_NAMESPACE", "left")
    assert again(ALARMS, "--nodes", str(ALARMS)) == []
    assert again(SYSTEM, str(SYSTEM), "alarms:=false") == []
    assert running_again(ALARMS, ["/usr/bin/python3", "/usr/bin/rostest", str(ALARMS)]) == []


def test_a_publisher_of_the_robots_links_may_be_started_twice(calls):
    """As by robot.launch and kinova.launch, for the stand-in of Kinova's drivers."""
    assert again(LAUNCH / "robot.launch", str(LAUNCH / "robot.launch")) == []


def test_another_master_is_another_system(calls, monkeypatch):
    monkeypatch.setenv("ROS_NAMESPACE", "left")
    assert again(ALARMS, "-p", str(free_port()), str(ALARMS)) == []


def test_roslaunch_starts_nothing_and_names_the_node(calls, monkeypatch):
    monkeypatch.setenv("ROS_NAMESPACE", "left")
    calls.clear()
    words = ["roslaunch", str(SYSTEM), "voice:=false"]
    done = subprocess.run(words, capture_output=True, text=True, timeout=PATIENCE)
    assert done.returncode
    assert "running node is '/left/alarms', allowed: none of this launch" in done.stderr
    assert not {"setParam", "registerPublisher"} & set(calls)

# SPDX-License-Identifier: BSD-3-Clause
"""Which processes are watched, with a made-up ROS system: only the answers of its APIs."""

import pytest
import rosgraph
import rospy

from rst_control.host.processes import ENDED
from rst_control.ros.common import peers
from rst_control.ros.common.peers import SILENCES, SILENT, UNREACHABLE, Peers
from rst_control.supervision.node_liveness import MASTER

MASTER_URI = "http://127.0.0.1:11311"


class Running:
    """A process of this host."""

    def __init__(self):
        self.words = ""

    def state(self):
        return self.words


class System:
    """Nodes by name: number of the process that each says, or an error of its API."""

    def __init__(self, monkeypatch):
        self.pids, self.uris, self.here = {MASTER_URI: 1}, {}, {1: Running()}
        monkeypatch.setattr(peers, "ask", self.ask)
        monkeypatch.setattr(peers, "process_of", lambda pid, _: self.here.get(pid))
        monkeypatch.setattr(peers, "SEARCH_PERIOD", 0.0)
        monkeypatch.setattr(rosgraph, "get_master_uri", lambda: MASTER_URI)
        monkeypatch.setattr(rospy, "get_name", lambda: "/controller")

    def ask(self, uri, method, *arguments):
        found = self.pids[uri]
        if isinstance(found, Exception):
            raise found
        return found if method == "getPid" else self.uris[arguments[-1]]

    def add(self, name, pid, is_here=True):
        self.uris[name] = uri = f"http://127.0.0.1:{40000 + pid}"
        self.pids[uri] = pid
        if is_here:
            self.here[pid] = Running()
        return uri


@pytest.fixture
def system(monkeypatch):
    return System(monkeypatch)


def seen(watched, name):
    """What is known after another look."""
    watched.step()
    return watched.state(name)


def test_a_node_of_this_host_that_ends_is_reported_and_found_again_when_it_is_back(system):
    watched = Peers()
    first = system.add("/voice", 7)
    watched.want({"/voice"})
    assert seen(watched, "/voice") == ""
    system.here[7].words = ENDED
    system.pids[first] = ConnectionRefusedError()
    assert seen(watched, "/voice") == ENDED
    system.add("/voice", 8)
    assert seen(watched, "/voice") == ""


def test_a_node_elsewhere_is_unknown_even_where_one_of_that_name_ended_here(system):
    watched = Peers()
    system.add("/voice", 7)
    watched.want({"/voice"})
    watched.step()
    system.here[7].words = ENDED
    system.add("/voice", 9, is_here=False)
    assert seen(watched, "/voice") == ""


def test_the_master_that_ends_is_reported_at_once_and_its_successor_is_taken(system):
    watched = Peers()
    assert seen(watched, MASTER) == ""
    system.here[1].words = ENDED
    assert watched.state(MASTER) == ENDED
    system.pids[MASTER_URI] = ConnectionRefusedError()
    assert seen(watched, MASTER) == ENDED
    system.pids[MASTER_URI], system.here[2] = 2, Running()
    assert seen(watched, MASTER) == ""


def test_a_master_elsewhere_is_lost_when_nobody_is_there_or_nobody_answers(system):
    system.here.clear()
    watched = Peers()
    assert seen(watched, MASTER) == ""
    system.pids[MASTER_URI] = TimeoutError()
    for _ in range(SILENCES - 1):
        assert seen(watched, MASTER) == ""
    assert seen(watched, MASTER) == SILENT
    system.pids[MASTER_URI] = 1
    assert seen(watched, MASTER) == ""
    system.pids[MASTER_URI] = ConnectionRefusedError()
    assert seen(watched, MASTER) == UNREACHABLE


def test_a_node_that_is_wanted_again_is_not_the_process_that_it_was(system):
    watched = Peers()
    system.add("/panel", 7)
    watched.want({"/panel"})
    assert seen(watched, "/panel") == ""
    watched.want(())  # its motion is over
    system.here[7].words = ENDED
    system.add("/panel", 8)
    watched.want({"/panel"})
    assert watched.state("/panel") == ""
    assert seen(watched, "/panel") == ""
    system.here[8].words = ENDED
    assert watched.state("/panel") == ENDED


def test_what_is_found_too_late_is_not_kept(system, monkeypatch):
    watched = Peers()
    system.add("/panel", 7)
    watched.want({"/panel"})

    def process_of(pid, _):
        watched.want(())  # it is not wanted any more once the answer is there
        return system.here[pid]

    monkeypatch.setattr(peers, "process_of", process_of)
    watched.step()
    system.here[7].words = ENDED
    assert watched.state("/panel") == ""


def test_who_is_not_wanted_any_more_is_forgotten(system):
    watched = Peers()
    for k in range(50):
        system.add(f"/client_{k}", 100 + k)
        watched.want({f"/client_{k}"})
        watched.step()
    assert len(watched._processes) <= 2

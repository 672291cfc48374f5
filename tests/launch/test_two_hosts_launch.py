# SPDX-License-Identifier: BSD-3-Clause
"""launch/two_hosts.launch puts each part on its host, with that host's address."""

from pathlib import Path

import pytest
import rosgraph.network
import yaml
from roslaunch.core import is_machine_local

from rst_control.config import load_motion_config
from tests.support.launch_reading import loaded

LAUNCH = Path(__file__).resolve().parents[2] / "launch"
ON_ROBOT = {"robot", "robot_state_publisher", "controller", "master_failover", "recorder"}
ON_VOICE = {"voice_assist", "alarms"}
ADDRESSES = ("robot_address:=203.0.113.1", "voice_address:=203.0.113.2")  # RFC 5737: nobody's


def launched(*arguments):
    """The launch file as `roslaunch` reads it, each node with its machine."""
    config = loaded([str(LAUNCH / "two_hosts.launch"), *arguments])
    config.assign_machines()
    return config


def by_name(*arguments):
    return {node.name: node for node in launched(*arguments).nodes}


@pytest.mark.parametrize(
    ("names", "address"),
    [(ON_ROBOT, "203.0.113.1"), (ON_VOICE, "203.0.113.2")],
    ids=["robot", "voice"],
)
def test_each_part_runs_on_its_host_and_announces_that_hosts_address(names, address, monkeypatch):
    monkeypatch.setattr(rosgraph.network, "get_local_addresses", lambda: ["127.0.0.1"])
    found = by_name(*ADDRESSES)
    assert set(found) == ON_ROBOT | ON_VOICE
    for name in names:
        assert found[name].machine.address == address, name
        assert dict(found[name].env_args)["ROS_HOSTNAME"] == address, name
        assert not is_machine_local(found[name].machine), name


def test_controller_and_robot_are_never_apart():
    found = by_name(*ADDRESSES)
    assert found["controller"].machine is found["robot"].machine


def test_the_address_of_the_host_that_launches_wins_nowhere(monkeypatch):
    monkeypatch.setenv("ROS_IP", "203.0.113.9")
    for node in by_name(*ADDRESSES).values():
        # rosgraph.network asks for ROS_HOSTNAME before ROS_IP
        assert dict(node.env_args)["ROS_HOSTNAME"] in ("203.0.113.1", "203.0.113.2"), node.name


def test_user_and_env_loader_are_those_of_their_host_alone():
    found = by_name(
        *ADDRESSES, "voice_user:=theatre", "voice_env_loader:=/ws/env.sh", "ssh_timeout:=3"
    )
    voice, robot = found["voice_assist"].machine, found["robot"].machine
    assert (voice.user, voice.env_loader, voice.timeout) == ("theatre", "/ws/env.sh", 3.0)
    assert robot.user is None and robot.env_loader != "/ws/env.sh"


def test_without_addresses_all_is_on_this_host_without_ssh():
    for node in launched().nodes:
        assert is_machine_local(node.machine), node.name
        assert dict(node.env_args)["ROS_HOSTNAME"] == "127.0.0.1", node.name


def test_a_voice_that_ends_does_not_end_the_robot():
    found = by_name(*ADDRESSES)
    assert not found["voice_assist"].required
    assert found["controller"].required and found["robot"].required


def test_two_hosts_allow_less_silence_than_one():
    parameters = launched().params
    age = parameters["/controller/controller/watchdogs/voice_heartbeat_age"].value
    given = yaml.safe_load((LAUNCH / "two_hosts.yaml").read_text())
    assert age == given["controller"]["watchdogs"]["voice_heartbeat_age"]
    assert age < load_motion_config().controller.watchdogs.voice_heartbeat_age

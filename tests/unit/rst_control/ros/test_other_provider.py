# SPDX-License-Identifier: BSD-3-Clause
"""Who else offers a service: the living and the hanging count, the dead do not."""

from contextlib import nullcontext
from types import SimpleNamespace

import pytest

from rst_control.kinova.stand_in import load_stand_in_config
from rst_control.ros.common import other_provider as module
from rst_control.ros.simulator import node as simulator_node
from typed_config.ros import xmlrpc

SERVICE = "/rst_control/command"


@pytest.fixture
def offered(monkeypatch):
    """Sets who is registered for which service, who lives, who hangs; None: a silent master."""

    def set_up(services, living, hanging=()):
        def ask(uri, method, *arguments):
            if services is None:
                raise TimeoutError
            if method == "getSystemState":
                return [[], [], services]
            if method == "lookupNode":
                return f"http://{arguments[1]}"
            if uri.removeprefix("http://") in living:
                return 4711
            if uri.removeprefix("http://") in hanging:
                raise TimeoutError
            raise ConnectionRefusedError

        monkeypatch.setattr(module, "ask", ask)
        monkeypatch.setattr(xmlrpc, "ask", ask)

    monkeypatch.setattr(module.rospy, "get_name", lambda: "/second")
    monkeypatch.setattr(module.rospy, "resolve_name", lambda name: f"/{name}")
    monkeypatch.setattr(module.rosgraph, "get_master_uri", lambda: "http://master")
    return set_up


@pytest.mark.parametrize(
    ("services", "living", "found"),
    [
        ([[SERVICE, ["/controller"]]], ["/controller"], "/controller"),
        ([[SERVICE, ["/controller"]]], [], ""),
        ([[SERVICE, ["/dead", "/controller"]]], ["/controller"], "/controller"),
        ([[SERVICE, ["/second"]]], ["/second"], ""),
        ([["/left/rst_control/command", ["/left/controller"]]], ["/left/controller"], ""),
        ([], [], ""),
        (None, [], ""),
    ],
)
def test_another_living_node_is_named(offered, services, living, found):
    offered(services, living)
    assert module.other_provider("rst_control/command") == found


def test_a_node_that_hangs_may_go_on_and_counts(offered):
    offered([[SERVICE, ["/dead", "/controller"]]], living=[], hanging=["/controller"])
    assert module.other_provider("rst_control/command") == "/controller"


class BegunError(Exception):
    """The simulated robot is made, and with it its services."""


@pytest.fixture
def simulated(monkeypatch):
    """Starts the simulator, as a stand-in for the drivers or not; the fatal words."""

    def start(stand_in):
        said = []

        def make(*_):
            raise BegunError

        config = SimpleNamespace(simulator=SimpleNamespace(real_time_factor=2.0))
        monkeypatch.setattr(simulator_node, "limit_messages", lambda: None)
        monkeypatch.setattr(simulator_node, "publish_without_waiting", lambda: None)
        monkeypatch.setattr(simulator_node, "starting", lambda *_, **__: nullcontext())
        monkeypatch.setattr(simulator_node, "launch_settings", dict)
        monkeypatch.setattr(simulator_node, "read_parameters", lambda _: (config, stand_in))
        monkeypatch.setattr(simulator_node, "SimulatorNode", make)
        monkeypatch.setattr(
            simulator_node.rospy, "logfatal", lambda words, *values: said.append(words % values)
        )
        try:
            simulator_node.main()
        except SystemExit as ended:
            said.append(ended.code)
        return said

    return start


LIMITS, REQUEST = "/my_gen3/control_config/get_kinematic_soft_limits", "/openrst/openrst_request"


@pytest.mark.parametrize("service", [LIMITS, REQUEST])
def test_the_stand_in_does_not_start_beside_a_driver_of_its_names(offered, simulated, service):
    offered([[service, ["/driver"]]], ["/driver"])
    words, status = simulated(load_stand_in_config())
    assert "/driver is a driver" in words and "end the drivers first" in words
    assert status == 2


@pytest.mark.parametrize(
    ("service", "provider", "living"),
    [
        (LIMITS, "/second", True),  # its own, of before it crashed and was started anew
        (REQUEST, "/second", True),
        (LIMITS, "/driver", False),
        ("/other_gen3/control_config/get_kinematic_soft_limits", "/driver", True),
    ],
)
def test_the_stand_in_starts_where_no_other_driver_lives(
    offered, simulated, service, provider, living
):
    offered([[service, [provider]]], [provider] if living else [])
    with pytest.raises(BegunError):
        simulated(load_stand_in_config())


def test_a_robot_that_takes_set_points_stands_in_for_no_driver(offered, simulated):
    offered([[LIMITS, ["/driver"]]], ["/driver"])
    with pytest.raises(BegunError):
        simulated(None)

# SPDX-License-Identifier: BSD-3-Clause
"""Who else offers a service: the living and the hanging count, the dead do not."""

import pytest

from rst_control.ros.common import other_provider as module
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

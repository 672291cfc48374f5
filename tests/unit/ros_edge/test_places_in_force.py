# SPDX-License-Identifier: BSD-3-Clause
"""Trocar and grasp point that were set are kept for a restart, also after a lost master."""

import json

import pytest

from rst_control.registration.trocar_context import Origin
from rst_control.ros.common.wall_clock import RosClock
from rst_control.ros.controller.places import places_in_force as module
from tests.unit.rst_control.support.executor_rig import Rig


class Master:
    """Keeps parameters while it is there."""

    def __init__(self):
        self.is_there, self.kept = True, {}

    def ask(self, uri, method, caller, key, value):
        if not self.is_there:
            raise ConnectionRefusedError("nobody is there")
        assert (uri, method) == ("http://master", "setParam")
        self.kept[key] = value


def resolved(name):
    return name.replace("~", "/controller/")


@pytest.fixture
def master(monkeypatch):
    master = Master()
    topic = type("Topic", (), {"publish": lambda *_: None})
    for name, value in {
        "Publisher": lambda *_, **__: topic(),
        "get_name": lambda: "/controller",
        "resolve_name": resolved,
        "get_param": lambda name, default: master.kept.get(resolved(name), default),
        "logwarn": lambda *_: None,
    }.items():
        monkeypatch.setattr(module.rospy, name, value)
    monkeypatch.setattr(module.rosgraph, "get_master_uri", lambda: "http://master")
    monkeypatch.setattr(module, "ask", master.ask)
    return master


def moved(context):
    x, y, z = context.current.trocar
    context.current = context.current.with_trocar((x + 1e-4, y, z))
    context.trocar_origin = Origin("/panel", 5.0)
    return [x + 1e-4, y, z]


def test_what_is_set_counts_after_a_restart(master):
    rig = Rig()
    places = module.PlacesInForce(rig.context, RosClock())
    trocar = moved(rig.context)
    places.step()
    again = Rig()
    module.PlacesInForce(again.context, RosClock())
    assert again.context.current.trocar.tolist() == pytest.approx(trocar)
    assert again.context.trocar_origin.source == "/panel"


def test_what_is_set_while_the_master_is_away_is_kept_once_it_is_back(master, monkeypatch):
    rig = Rig()
    places = module.PlacesInForce(rig.context, RosClock())
    master.is_there = False
    trocar = moved(rig.context)
    places.step()  # who set it must hear that it is set
    master.is_there = True
    monkeypatch.setattr(module, "KEEP_AGAIN", 0.0)
    places.step()
    assert master.kept == {}  # not yet: the master is asked seldom
    monkeypatch.setattr(module.time, "monotonic", lambda: 1e9)
    places.step()
    kept = json.loads(master.kept["/controller/in_force/places"])
    assert kept["trocar"]["numbers"] == pytest.approx(trocar)

# SPDX-License-Identifier: BSD-3-Clause
"""A USB pedal that cannot be read, lacks an input or loses events."""

from types import SimpleNamespace

import pytest

from tests.unit.ros_edge.pedal.bare_pedal import BRAKED, HELD, MORE, STOP, Acting, noting_node
from voice_assist.pedal import evdev
from voice_assist.pedal.evdev import EventsLostError
from voice_assist.pedal.pedals import Brake
from voice_assist.ros.pedal import node as pedal_node


@pytest.mark.parametrize("error", [OSError("No such device"), ValueError("strange bytes")])
def test_a_device_that_fails_releases_the_dead_man(monkeypatch, error):
    def fail(name):
        raise error

    turns = iter([False, True])
    fake = SimpleNamespace(
        is_shutdown=lambda: next(turns),
        logwarn=lambda *_: None,
        rostime=SimpleNamespace(wallsleep=lambda _: None),
    )
    monkeypatch.setattr(pedal_node, "rospy", fake)
    monkeypatch.setattr(pedal_node, "find", fail)
    node = noting_node(actions := [])
    node._pedals.found()
    for value in (0.0, 1.0):
        node._pedals.take({"button 0": value})
    assert node._pedals.is_held
    node._read()
    assert not node._pedals.is_held
    assert isinstance(actions[0], Brake) and str(error) in actions[0].why


def bits(length, *codes):
    made = bytearray(length)
    for code in codes:
        made[code // 8] |= 1 << code % 8
    return bytes(made)


@pytest.mark.parametrize("source", ["button 48", "button 49", "axis 1", "axis 2"])
@pytest.mark.parametrize("does", ["talk", "mute"])
def test_an_input_that_a_usb_pedal_does_not_have_is_named_and_closes_the_gate(
    monkeypatch, tmp_path, source, does
):
    state = {0x80604521: bits(96, 48), 0x80084523: bits(8, 1)}  # EVIOCGBIT of keys, of axes
    monkeypatch.setattr(evdev.fcntl, "ioctl", lambda _, request, at: state.get(request, at))
    (tmp_path / "event1").write_bytes(b"")
    turns, said = iter([False, True]), []
    fake = SimpleNamespace(
        is_shutdown=lambda: next(turns),
        loginfo=lambda *_: None,
        logwarn=lambda words, *parts: said.append(words % parts),
        rostime=SimpleNamespace(is_wallclock=lambda: True, wallsleep=lambda _: None),
    )
    monkeypatch.setattr(pedal_node, "rospy", fake)
    monkeypatch.setattr(pedal_node, "DEVICES", tmp_path)
    monkeypatch.setattr(pedal_node, "find", lambda _: "event1")
    bound = {"input": source, "above": 0.5, "does": does, "command": ""}
    node, may_talk = noting_node([], bound), []
    node._carry_out = lambda *_: may_talk.append(node._pedals.may_talk)
    node._read()
    is_there = source in ("button 48", "axis 1")
    words = f"pedal: the device has no {source}, which pedal.yaml names"
    assert (said[0] == words) is not is_there and said.count(words) <= 1
    assert any(may_talk) is (is_there and does == "mute")


# Events that the kernel had no room for; a tap of a stop may be among them.


@pytest.mark.parametrize(
    ("bound", "acts"),
    [((STOP, MORE), BRAKED), ((MORE,), []), ((STOP, {**HELD, "input": "button 1"}), BRAKED)],
)
def test_lost_events_stop_where_a_stop_is_bound_and_the_device_is_opened_at_once(
    monkeypatch, bound, acts
):
    """After a loss of another kind it is looked for after a while only."""
    acting, opened = Acting(monkeypatch, *bound), []

    class Reader:
        stamp = 0.0

        def __init__(self, *_):
            opened.append(self)
            acting.acts.append("opened")

        def __enter__(self):
            return self

        def __exit__(self, *_):
            pass

        def inputs(self):
            return {"button 0", "button 1"}

        def __iter__(self):
            yield {"button 0": 0.0, "button 1": 0.0}
            raise EventsLostError("events were lost") if len(opened) == 1 else OSError("unplugged")

    acting.rospy.is_shutdown = lambda: "waited" in acting.acts
    acting.rospy.rostime.wallsleep = lambda _: acting.acts.append("waited")
    monkeypatch.setattr(pedal_node, "EvdevReader", Reader)
    monkeypatch.setattr(pedal_node, "find", lambda _: "event1")
    acting.node._read()
    assert acting.acts == ["opened", *acts, "opened", "waited"]
    assert any("a stop may have been among them" in words for words in acting.words) is bool(acts)


def test_lost_events_while_the_dead_man_is_held_stop_once_and_release_it(monkeypatch):
    acting = Acting(monkeypatch, HELD, {**STOP, "input": "button 1"})
    acting.node._take({"button 0": 1.0})
    acting.acts.clear()
    acting.node._lost("events were lost", are_events_lost=True)
    acting.node._tell()
    assert acting.acts == [*BRAKED, "dead-man False"]

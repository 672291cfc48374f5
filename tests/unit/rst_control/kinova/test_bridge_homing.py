# SPDX-License-Identifier: BSD-3-Clause
"""The tool is taken out of service to be homed only while the arm stands, and then it stays."""

from dataclasses import replace

import numpy as np
import pytest

from rst_control.kinova.bridge import Lead
from rst_control.kinova.feedback import JointFeedback
from rst_control.kinova.homing import home
from rst_control.kinova.stand_in import load_stand_in_config
from rst_control.kinova.stand_in.openrst import OpenRst
from tests.unit.rst_control.kinova.fake_hardware import closing, standing


def test_it_is_not_homed_while_tissue_is_held_or_the_arm_is_led(hardware, way):
    tool = hardware.bridge.tool
    hardware.bridge.on_contact(True)
    hardware.bridge._grip.is_gripped = True
    assert "hold tissue" in hardware.bridge.begin_homing() and tool.is_homed
    hardware.bridge._grip.is_gripped = False
    hardware.advance(1.0, way)
    assert "not at rest (course)" in hardware.bridge.begin_homing() and tool.is_homed
    hardware.bridge.fail("failed on purpose", hardware.now)
    hardware.advance(0.1, way)
    assert np.abs(hardware.speed).max() > 0.01
    assert "not at rest" in hardware.bridge.begin_homing() and tool.is_homed


def test_an_arm_that_is_held_in_place_is_stopped_for_homing_and_waits_for_hey_robot(hardware):
    still, bridge = standing(hardware), hardware.bridge
    hardware.advance(1.0, still)
    assert bridge.lead is Lead.COURSE
    place, sent = hardware.arm.copy(), len(hardware.tools)
    assert bridge.begin_homing() == ""
    assert not bridge.tool.is_homed
    hardware.advance(1.0, still)  # the controller goes on for a moment
    assert bridge.lead is Lead.NOBODY and hardware.stops
    np.testing.assert_array_equal(hardware.arm, place)
    assert len(hardware.tools) == sent
    bridge.tool.is_homed = True
    hardware.advance(0.5, still)
    assert bridge.lead is Lead.NOBODY and "hey robot" in bridge.fault(hardware.now)
    bridge.clear_fault(hardware.now)
    hardware.advance(0.5, standing(hardware))
    assert bridge.fault(hardware.now) == "" and bridge.lead is Lead.COURSE


@pytest.mark.parametrize("what", ["course", "sent", "measured", "old", "none"])
def test_an_arm_that_is_led_and_perhaps_moves_is_not_homed(hardware, what):
    hardware.advance(1.0, standing(hardware))
    bridge, arm = hardware.bridge, hardware.bridge._ready.arm
    some, last = np.full(7, 0.02), bridge.last_course
    if what in ("course", "sent"):
        bridge.last_course = replace(last, **{"speed" if what == "course" else "sent": some})
    elif what == "none":
        bridge.last_course = None
    else:
        bridge._ready.arm = replace(arm, **({"velocity": some} if what == "measured" else {}))
        bridge._stepped += 0.1 * (what == "old")
    assert "not at rest (course)" in bridge.begin_homing()
    assert bridge.tool.is_homed and bridge.fault(hardware.now) == ""


def test_jaws_that_homing_left_open_hold_no_tissue(hardware):
    hardware.advance(1.5, closing(hardware))
    assert hardware.bridge.begin_homing() == ""
    hardware.tool_joints[1:] = 0.2
    hardware.advance(1.0)
    hardware.bridge.tool.is_homed = True
    hardware.advance(0.5)
    assert not hardware.bridge.is_gripped


def test_while_it_is_homed_no_set_point_moves_the_arm(hardware, way):
    assert hardware.bridge.begin_homing() == ""
    place = hardware.arm.copy()
    hardware.advance(1.0, way)
    np.testing.assert_array_equal(hardware.arm, place)
    assert "not homed" in hardware.bridge.fault(hardware.now)


class OnStandIn:
    """OpenRST's node as the stand-in has it, and what a bridge knows of it, on one clock."""

    def __init__(self, bridge):
        config = replace(load_stand_in_config().tool, homing_speed=1.4, homing_dwell=0.02)
        self.node, self.bridge, self.now = OpenRst(config, (0.0, 0.0, 0.0)), bridge, 100.0

    def wait(self, condition, limit):
        end = self.now + limit
        while not condition():
            if self.now > end:
                return False
            self.now += 0.008
            self.node.step(self.now, is_gripping=False)
            self.bridge.tool.update_state(self.node.state.value)
            if (seen := self.node.reported) is not None:
                self.bridge.on_tool(JointFeedback(seen, np.zeros(3), np.zeros(3), self.now))
        return True

    def request(self, message):
        answers = []
        self.node.request(message, answers.append)
        return self.wait(lambda: answers, 60.0)

    def home(self):
        return home(self.request, self.bridge.tool, self.node.take_command, self.wait)


def test_a_tool_that_was_led_before_stays_where_its_homing_ends(hardware):
    rig = OnStandIn(hardware.bridge)
    rig.home()
    rig.node.take_command([0.8, -0.3, 0.5])
    rig.wait(lambda: False, 3.0)
    assert rig.node.position == pytest.approx([0.8, -0.3, 0.5], abs=1e-6)
    assert hardware.bridge.begin_homing() == ""
    assert "homed" in rig.home()
    rig.wait(lambda: np.abs(rig.node.position).max() > 0.01, 3.0)
    assert rig.node.position == pytest.approx([0.0, 0.0, 0.0], abs=0.01)

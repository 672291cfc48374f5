# SPDX-License-Identifier: BSD-3-Clause
"""A bridge that did not run while the arm moved, and then runs again, moves nothing by itself."""

import numpy as np
import pytest

from bench.kinova.rig import KinovaRig, kinova_motion
from rst_control.kinova.bridge import Lead
from rst_control.types import Setpoint


@pytest.fixture(scope="module")
def homed():
    with KinovaRig(kinova_motion()) as rig:
        rig.run(0.1)
        rig.home()
        yield rig


@pytest.fixture
def rig(homed):
    """In motion, and at rest again behind it, with nothing lost."""
    assert homed.give("hey robot").reply.result(0).accepted
    assert homed.give("tense").reply.result(0).accepted
    assert homed.until(lambda: homed.speed > 0.05)
    yield homed
    homed.lost = None
    homed.give("stop")
    homed.run(1.0)
    assert homed.speed < 1e-3


def joints(rig):
    return np.array(rig.robot.reading.position[:7])


def test_it_stays_where_the_guard_stopped_it_and_says_why(rig):
    rig.lost = "bridge"
    rig.run(1.0)
    assert rig.speed < 1e-3
    while (rig._steps + 1) % 25:  # what it hears first is fresh: only its own clock shows the gap
        rig.step()
    place, rig.lost = joints(rig), None
    rig.run(2.0)
    np.testing.assert_allclose(joints(rig), place, atol=1e-4)
    assert "did not run" in rig.bridge.fault(rig.now)


def test_without_a_guard_it_brakes_the_arm_itself(rig, monkeypatch):
    """Nobody has braked meanwhile, so nothing of the braking is left out."""
    ready, hardware, speeds = rig.bridge._ready, rig.bridge._hardware, []
    stop = hardware.stop
    monkeypatch.setattr(ready, "guard", -np.inf)
    monkeypatch.setattr(rig.bridge, "on_guard", lambda _: None)
    monkeypatch.setattr(ready, "_unguarded", lambda _: "")  # none is required
    monkeypatch.setattr(rig, "_guarded", lambda _: None)
    rig.lost = "bridge"
    rig.run(0.3)
    assert rig.speed > 0.05
    rig.lost = None
    monkeypatch.setattr(hardware, "stop", lambda: (speeds.append(rig.speed), stop()))
    rig.run(0.5)
    monkeypatch.undo()
    assert "did not run" in rig.bridge.fault(rig.now)
    assert speeds[0] < 1e-3  # the driver's stop follows once the arm has come to rest


def test_one_that_its_guard_does_not_hear_brakes_and_says_so(rig, monkeypatch):
    # A connection that was never opened, or a name not believed
    monkeypatch.setattr(rig.guard, "heard", lambda *_: None)
    rig.run(1.0)
    assert rig.speed < 1e-3
    assert "stop guard" in rig.bridge.fault(rig.now)


def test_one_that_is_merely_late_goes_on(rig):
    late = 0.4 * rig.bridge._config.guard.silence
    while rig._steps % rig._feedback:  # a state of the arm has just come
        rig.step()
    rig.lost = "bridge"
    rig.run(late)
    rig.lost = None
    rig.run(0.2)
    assert rig.bridge.fault(rig.now) == ""
    assert rig.speed > 1e-3


def test_one_that_is_late_at_rest_takes_the_set_points_that_waited(hardware, way):
    hardware.advance(0.1)
    hardware.now += 0.065  # nothing ran
    hardware.start += 0.065
    hardware.arm = hardware.arm + 1e-6  # no state twice, as from a real arm
    hardware.report_all()
    hardware.bridge.servo_jp(Setpoint(*way(hardware.now), hardware.now), hardware.now)
    hardware.bridge.step(hardware.now)
    hardware.advance(0.05, way)
    assert hardware.bridge.fault(hardware.now) == ""
    assert hardware.bridge.lead is Lead.COURSE

# SPDX-License-Identifier: BSD-3-Clause
"""One factor slows everything down that is planned, and leaves braking as hard as it was."""

from dataclasses import replace

import numpy as np
import pytest

from rst_control.execution.motion import MotionMaker
from rst_control.kinematics.configuration import robot_joints
from rst_control.planning.plan import Phase, PhaseKind
from rst_control.planning.planner import Planner, along
from rst_control.types import Measurement, State
from tests.unit.rst_control.support.executor_rig import Rig, with_watchdogs


def scaled(config, scale):
    speed = replace(config.controller.speed, scale=scale)
    return replace(config, controller=replace(config.controller, speed=speed))


@pytest.mark.parametrize("scale", [0.1, 0.5])
def test_every_path_is_taken_more_slowly(robot, motion_config, planner, home, scale):
    slow = Planner(robot, scaled(motion_config, scale))
    for path in (*planner.reach(home), planner.pull(planner.reach(home)[-1].end)):
        full = along(planner, PhaseKind.REACH, path, 0.010)
        part = along(slow, PhaseKind.REACH, path, 0.010)
        assert part.speed == pytest.approx(scale * full.speed, rel=0.01)
        assert part.braking >= full.braking * 0.999


def test_the_jaws_too(motion_config, home):
    held = robot_joints(home, 0.0)
    still = np.zeros(10)
    measured = Measurement(held, still, still, 0.0)
    times = []
    for scale in (1.0, 0.1):
        maker = MotionMaker(scaled(motion_config, scale).controller)
        run = maker.start_phase(Phase(PhaseKind.OPEN, opening=0.6), held, None)
        count = 0
        while not run.is_done:
            run.step(maker.period, measured)
            count += 1
        times.append(count * maker.period)
    jaws = motion_config.controller.jaws
    assert times[1] == pytest.approx(0.6 / (0.1 * jaws.speed), rel=0.1)
    assert times[0] < 0.5 * times[1]


def test_jaws_that_open_slowly_may_take_their_time():
    config = with_watchdogs(phase_timeout=2.0)
    jaws = replace(config.controller.jaws, speed=0.1)
    rig = Rig(config=replace(config, controller=replace(config.controller, jaws=jaws)))
    rig.awake().say("tense")
    start = rig.now
    rig.until(lambda: rig.phase == "reach")
    assert rig.now - start > 5.0


def test_jaws_that_take_longer_than_planned_brake():
    rig = Rig(config=with_watchdogs(phase_timeout=2.0)).moving("open")
    rig.now += 3.5
    rig.until(lambda: rig.state is State.FAULTED, limit=0.5)
    assert "s longer than planned, allowed 2 s" in rig.view.mode.reason

# SPDX-License-Identifier: BSD-3-Clause
"""One factor slows everything down that is planned, and leaves braking as hard as it was."""

import numpy as np
import pytest

from rst_control.execution.motion import MotionMaker
from rst_control.kinematics.configuration import robot_joints
from rst_control.planning.plan import Phase, PhaseKind
from rst_control.planning.planner import along
from rst_control.types import Measurement
from tests.support.changed_settings import changed, planner_with
from tests.unit.rst_control.support.executor_rig import Rig, with_watchdogs


@pytest.mark.parametrize("scale", [0.1, 0.5])
def test_every_path_is_taken_more_slowly(planner, home, scale):
    slow = planner_with(planner, speed={"scale": scale})
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
        maker = MotionMaker(changed(motion_config, speed={"scale": scale}).controller)
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
    rig = Rig(config=changed(with_watchdogs(phase_timeout=2.0), jaws={"speed": 0.1}))
    rig.awake().say("tense")
    start = rig.now
    rig.until(lambda: rig.phase == "reach")
    assert rig.now - start > 5.0

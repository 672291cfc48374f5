# SPDX-License-Identifier: BSD-3-Clause
"""An endoscope led in eight directions and back in PyBullet, and stopped on its way."""

import numpy as np
import pytest

from bench.common.rig import Rig
from bench.motion.insertion import InsertionRun
from rst_control.commands.camera_step import STEPS
from rst_control.config import load_motion_config, load_simulation_config
from rst_control.types import State

WORST = 20e-6  # [m] of the shaft from the trocar, after every step of the physics
OPPOSITE = {tuple(np.negative(step)): phrase for phrase, step in STEPS.items()}


@pytest.fixture(scope="module")
def rig():
    with Rig(load_motion_config(), load_simulation_config()) as made:
        made.run(0.02)
        made.wake()
        yield made


def test_eight_directions_and_closer_and_back_with_the_shaft_in_the_trocar(rig):
    run, start = InsertionRun(rig), rig.executor.snapshot.setpoint
    done = set()
    for phrase, step in STEPS.items():
        if phrase not in done:  # as the way back of another
            run.finish(phrase)
            run.finish(OPPOSITE[step])
            done |= {phrase, OPPOSITE[step]}
    assert run.failure == "" and run.phases == {"look", "hold"}
    assert 0.0 < run.error < WORST
    print(f"largest RCM error: {run.error * 1e6:.2f} um")
    np.testing.assert_allclose(rig.executor.snapshot.setpoint, start, atol=5e-3)


def test_a_stop_on_the_way_holds_the_shaft_in_the_trocar(rig):
    rig.give("look down left")
    assert rig.until(lambda: _progress(rig) > 0.4)
    rig.give("stop")
    assert rig.until(lambda: rig.executor.snapshot.mode.state is State.HALTED, limit=1.0)
    assert 0.3 < rig.executor.snapshot.path_position / rig.executor.snapshot.path.length < 0.9
    assert rig.executor.snapshot.trocar_pose.error < WORST


def _progress(rig):
    motion = rig.executor.snapshot.motion
    return motion.progress if motion is not None else 0.0

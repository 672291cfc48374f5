# SPDX-License-Identifier: BSD-3-Clause
"""A session in PyBullet that begins with the tool outside the patient, and ends there."""

from dataclasses import replace

import numpy as np

from bench.common.rig import Rig, with_speed
from bench.motion.insertion import InsertionRun
from rst_control.config import load_motion_config, load_simulation_config
from rst_control.kinematics.robot_model import load_robot
from rst_control.planning.insertion import Insertion
from rst_control.planning.planner import Planner

WORST = 10e-6  # [m] of the shaft from the trocar, after every step of the physics


def start():
    """Beside the trocar, to keep the test short; the bench begins all over the joints' ranges."""
    planner = Planner(load_robot(), load_motion_config())
    way_out = Insertion(planner).withdraw(np.array(planner.config.scene.home))
    return way_out[-1].path.end + 0.4 * np.eye(9)[0]


def rig_at(q):
    motion, simulation = load_motion_config(), load_simulation_config()
    motion = with_speed(motion, insertion=0.05, approach=0.1)  # to be quick
    settings = replace(simulation.simulator, start_position=tuple(q.tolist()))
    return Rig(motion, replace(simulation, simulator=settings))


def test_in_to_the_tissue_and_out_again_with_the_shaft_in_the_trocar():
    with rig_at(start()) as rig:
        rig.run(0.02)
        assert rig.executor.snapshot.insertion < 0.0
        assert "hey robot" in rig.finish("insert")
        rig.wake()
        run = InsertionRun(rig)
        for words in ("insert", "tense", "release", "withdraw"):
            run.finish(words)
        assert run.failure == ""
        assert run.phases >= {"approach", "align", "insert", "reach", "pull", "withdraw"}
        assert 0.0 < run.error < WORST
        np.testing.assert_allclose(rig.executor.snapshot.insertion, -0.030, atol=1e-4)
        assert rig.robot.fault == ""

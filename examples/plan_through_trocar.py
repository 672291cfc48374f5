#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Plans the way to the tissue through the trocar, and prints how far the shaft strays from it.

It needs no ROS master: . catkin_ws/devel/setup.sh; .venv/bin/python examples/plan_through_trocar.py
"""

from __future__ import annotations

import numpy as np

from rst_control import Configuration, Planner, load_motion_config, load_robot, rcm_state

PLACES = 200  # along each path


def main() -> None:
    """Plan from home to the grasp, then the pull."""
    config, model = load_motion_config(), load_robot()
    planner = Planner(model, config)
    paths = planner.reach(np.array(config.scene.home))
    paths = (*paths, planner.pull(paths[-1].end))
    for number, path in enumerate(paths, start=1):
        errors = []
        for s in np.linspace(0.0, path.length, PLACES):
            here = Configuration(model, path.evaluate(s).q)
            errors.append(rcm_state(here, planner.trocar).error)
        print(f"path {number}: {path.length * 1e3:.1f} mm, RCM error {max(errors) * 1e6:.3f} um")
    print(f"allowed {config.rcm.planned_tolerance * 1e6:.1f} um")


if __name__ == "__main__":
    main()

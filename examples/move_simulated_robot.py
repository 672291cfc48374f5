#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Moves the simulated robot by commands, and prints what happens; without a ROS master.

Start it like plan_through_trocar.py. Time is simulated: the run takes as long as it computes.
"""

import rst_control as rst


def main() -> None:
    """Make the robot ready, let it grasp and pull the tissue, and let it go."""
    config = rst.load_motion_config()
    trocar = rst.ActiveTrocarContext(rst.make_trocar_context(config, rst.load_robot()))
    with rst.PybulletRobot(rst.load_simulation_config(), start=10.0) as robot:
        executor = rst.make_executor(config, trocar, robot.clear_fault)
        commands = rst.CommandQueue(executor, trocar.verify, lambda: robot.now)

        def tick() -> None:
            if (setpoint := executor.tick(robot.now, robot.measured_js())) is not None:
                robot.servo_jp(setpoint)
            robot.advance(robot.now + 1.0 / config.controller.rate)

        tick()
        for words in ("hey robot", "tense", "release"):
            pending = commands.take(words, "example")
            if (queued := commands.next(0.0)) is not None:
                commands.check(queued)
            while not pending.ended.done():
                tick()
            view, answer = executor.snapshot, pending.reply.result()
            print(f'{robot.now:.1f} s "{words}": {answer.message}, {pending.ended.result().kind}')
            print(f"  tension {view.tension:.2f} N, RCM error {view.rcm_error * 1e6:.1f} um")


if __name__ == "__main__":
    main()

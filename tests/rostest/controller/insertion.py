#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The tool goes out and in by hand, by the service alone; that a voice may not: lost_nodes.py."""

from tests.support.robot_client import RobotTest, run_tests


class Insertion(RobotTest):
    """The tests run in the order of their names and build on one robot."""

    def test_1_a_stop_half_way_out_latches_and_hey_robot_lets_it_go_on(self):
        self.robot.start_fresh()
        self.assertIn("already inserted", self.robot.refused("insert"))
        self.robot.say("withdraw")
        self.robot.wait(lambda: self.robot.state.insertion < 0.09, limit=60)
        self.robot.say("stop")
        self.robot.wait_for_state("halted")
        self.robot.wait_for_rest()  # the robot plays set-points late
        self.assertLess(self.robot.drift(0.3), 1e-3)
        self.assertGreater(self.robot.state.insertion, 0.0)
        self.assertIn("halted", self.robot.refused("withdraw"))
        self.robot.activate()
        self.robot.say_and_finish("withdraw", limit=90)
        self.assertAlmostEqual(self.robot.state.insertion, -0.030, delta=0.002)
        self.assertIn("withdraw", {s.phase for s in self.robot.states})

    def test_2_outside_nothing_is_pulled(self):
        self.assertIn("tool not inserted", self.robot.refused("tense"))
        self.assertIn("already outside", self.robot.refused("withdraw"))

    def test_3_insert_takes_the_tool_to_its_working_pose(self):
        self.robot.say_and_finish("insert", limit=90)
        self.assertAlmostEqual(self.robot.state.insertion, 0.1205, delta=0.002)
        self.assertLess(self.robot.state.rcm_error, 20e-6)
        inside = [s.rcm_error for s in self.robot.states if s.insertion > 0.0]
        self.assertLess(max(inside), 50e-6)
        self.assertIn("insert", {s.phase for s in self.robot.states})


if __name__ == "__main__":
    run_tests(Insertion, "insertion")

#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""From the sound of an amount to a robot that goes for it, and near misses that move nothing."""

from tests.rostest.voice.spoken_topic import SpokenTo
from tests.support.robot_client import run_tests

SAID, SENT, TARGET = "tension one point five", "tense 1.5 N", 1.5  # [N]
NEAR = ("tension one point nine", "the tension is one point five")


class SpokenAmount(SpokenTo):
    """Amounts are on in this launch."""

    def test_an_amount_moves_the_robot_and_is_its_target(self):
        decided = self.say(SAID)
        self.assertEqual(decided.command, SAID, decided)
        self.robot.wait_for_state("moving")
        self.assertEqual(self.robot.state.command, SENT)
        self.robot.wait(lambda: self.robot.state.tension_target == TARGET)
        started = [e.command for e in self.robot.events if e.kind == "motion_started"]
        self.assertEqual(started[-1], SENT)
        self.robot.stop_topic.publish()
        self.robot.wait_for_state("halted")

    def test_near_misses_move_nothing(self):
        events = len(self.robot.events)
        for words in NEAR:
            decided = self.say(words)
            self.assertEqual(decided.command, "", decided)
        self.assertEqual(self.robot.state.state, "active")
        self.assertEqual([e.kind for e in self.robot.events[events:]], [])


if __name__ == "__main__":
    run_tests(SpokenAmount, "spoken_amount")

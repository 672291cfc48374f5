# SPDX-License-Identifier: BSD-3-Clause
from dataclasses import replace

from tests.unit.voice_assist.support.fake_speech import quiet_frame
from voice_assist.spotter.in_motion import SpotterInMotion
from voice_assist.spotter.spotter import Spotted

ALWAYS, SECOND = Spotted(1.0, 2.0), Spotted(1.0, 7.0)


class Scripted:
    """Fires one thing with every frame."""

    def __init__(self, fired):
        self.fired, self.heard, self.resets = fired, 0, 0

    def __call__(self, frame):
        self.heard += 1
        return self.fired

    def best(self, since, until=0):
        return self.fired.score

    def reset(self):
        self.resets += 1


def test_the_second_listens_only_while_the_robot_moves():
    first, second = Scripted(None), Scripted(SECOND)
    both = SpotterInMotion(first, second)
    assert both(quiet_frame()) is None and (first.heard, second.heard) == (1, 0)
    assert both(replace(quiet_frame(), is_moving=True)) == SECOND
    assert (first.heard, second.heard) == (2, 1)


def test_either_fires_and_the_first_gives_the_scores():
    both = SpotterInMotion(Scripted(ALWAYS), Scripted(None))
    assert both(quiet_frame()) == both(replace(quiet_frame(), is_moving=True)) == ALWAYS
    assert both.best(0.0) == ALWAYS.score


def test_both_forget():
    first, second = Scripted(None), Scripted(None)
    SpotterInMotion(first, second).reset()
    assert (first.resets, second.resets) == (1, 1)

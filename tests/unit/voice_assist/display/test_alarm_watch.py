# SPDX-License-Identifier: BSD-3-Clause
"""An alarm is shown as long as the node that says it is there and works."""

import threading

import pytest

from tests.unit.voice_assist.display.support.theatre import STOPPED, Clock, make_theatre
from voice_assist.display.snapshot import AlarmPart
from voice_assist.ros.alarms.alarm_watch import AlarmWatch


class Rig:
    """A watch whose clock and connection the test sets."""

    def __init__(self):
        self.theatre, self.clock, self.is_connected = make_theatre(), Clock(), True
        self.watch = AlarmWatch(self.theatre.see_alarm, lambda: self.is_connected, self.clock)

    @property
    def shown(self):
        return self.theatre.snapshot().alarm

    def pass_time(self, seconds, *nodes):
        """Let these nodes publish their diagnostics once a second meanwhile."""
        for _ in range(seconds):
            self.clock.now += 1.0
            for node in nodes:
                self.watch.see_status(node)
            self.watch.look_again()


@pytest.mark.parametrize("alarm", [STOPPED, AlarmPart()])
def test_a_node_that_hangs_counts_as_none_until_it_works_again(alarm):
    rig = Rig()
    rig.watch.see_alarm(alarm, "/alarms")
    rig.pass_time(20, "/alarms", "/recorder")
    assert rig.shown == alarm
    rig.pass_time(3, "/recorder")
    assert rig.shown == alarm
    rig.pass_time(1, "/recorder")
    assert rig.shown is None
    rig.pass_time(1, "/alarms")
    assert rig.shown == alarm


def test_the_last_word_of_a_node_that_went_is_not_that_of_the_next_one():
    rig = Rig()
    rig.watch.see_alarm(STOPPED, "/alarms")
    rig.is_connected = False
    rig.watch.look_again()
    assert rig.shown is None
    rig.is_connected = True
    rig.watch.look_again()
    assert rig.shown is None
    rig.watch.see_alarm(AlarmPart(), "/alarms")
    rig.watch.look_again()
    assert rig.shown == AlarmPart()


def test_a_word_that_comes_while_nobody_is_found_stays():
    rig = Rig()
    word = threading.Thread(target=lambda: rig.watch.see_alarm(STOPPED, "/alarms"))

    def is_connected():
        word.start()
        word.join(0.2)  # as long as it may
        return False

    watch = rig.watch = AlarmWatch(rig.theatre.see_alarm, is_connected, rig.clock)
    watch.look_again()
    word.join(10.0)
    assert rig.shown == STOPPED

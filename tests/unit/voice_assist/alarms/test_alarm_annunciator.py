# SPDX-License-Identifier: BSD-3-Clause
"""Which of the alarms that stand sounds, and when: repetition, interruption and silence."""

from itertools import pairwise

import pytest

from tests.unit.voice_assist.support.alarm_scene import CONFIG, LOST, OVER, STOPPED, Scene
from voice_assist.alarms.annunciator import GAP
from voice_assist.alarms.earcons import PATTERNS
from voice_assist.alarms.types import Earcon, Kind, Priority


def test_high_repeats_until_hey_robot_then_is_silent_and_still_seen():
    scene = Scene().be(state="moving").be(state="faulted", halt_reason=OVER).run(30.0)
    times = [time for time, earcon in scene.heard if earcon is Earcon.FAULT_HIGH]
    pause = PATTERNS[Earcon.FAULT_HIGH].duration + CONFIG.sound.repeat_high
    assert len(times) >= 4
    assert all(b - a == pytest.approx(pause, abs=0.11) for a, b in pairwise(times))
    scene.event("refused", "hey robot", "robot not connected")
    before = len(times)
    scene.run(30.0)
    assert scene.sounds().count(Earcon.FAULT_HIGH) == before
    assert scene.first.priority is Priority.HIGH


def test_a_stop_repeats_more_slowly_and_ends_with_its_cause():
    scene = Scene().be(state="halted", halt_reason=STOPPED).run(30.0)
    assert scene.sounds() == [Earcon.STOP] * 3
    scene.be(state="active", halt_reason="").run(30.0)
    assert scene.sounds() == [Earcon.STOP] * 3


@pytest.mark.parametrize(("state", "before", "times"), [("halted", 3.0, 2), ("stopping", 0.0, 1)])
def test_stop_said_again_is_heard_again_but_the_entry_of_the_same_stop_is_not(state, before, times):
    scene = Scene().be(state=state, halt_reason=STOPPED).run(before)
    scene.event("stop_received", "stop", STOPPED, "stop_topic").run(0.5 * times)
    assert scene.sounds() == [Earcon.STOP] * times


def test_a_higher_priority_interrupts_a_lower_one():
    scene = Scene().be(state="halted", halt_reason=STOPPED)
    scene.be(state="faulted", halt_reason=LOST, is_tissue_held=True)
    (first, stop), (second, fault) = scene.heard
    assert (stop, fault) == (Earcon.STOP, Earcon.FAULT_HIGH)
    assert second - first < PATTERNS[Earcon.STOP].duration


def test_nothing_of_the_same_or_a_lower_priority_interrupts():
    scene = Scene().be(state="halted", halt_reason=STOPPED)
    scene.event("refused", "tense", "halted (x); wait").run(3.0)
    (first, _), (second, refusal) = scene.heard
    assert refusal is Earcon.REFUSAL
    assert second - first >= PATTERNS[Earcon.STOP].duration + GAP - 0.051


def test_never_two_at_once_whatever_happens():
    scene = Scene()
    for turn in range(40):
        scene.event("refused", "tense", "busy moving")
        scene.be(state="halted" if turn % 3 else "active", halt_reason=STOPPED if turn % 3 else "")
        scene.event("accepted", "pull more", "goes").run(0.3)
    ends = [(t, t + PATTERNS[e].duration, PATTERNS[e].priority) for t, e in scene.heard]
    assert len(ends) > 10
    for (_, end, low), (start, _, high) in pairwise(ends):
        assert start >= end or high > low


def test_refusals_are_rate_limited_and_all_are_shown():
    scene = Scene()
    for _ in range(20):
        scene.event("refused", "tense", "busy moving").run(0.2)
    assert 2 <= scene.sounds().count(Earcon.REFUSAL) <= 3  # within 5 s
    assert scene.first.kind is Kind.REFUSAL


def test_while_high_sounds_notices_and_refusals_are_only_seen():
    scene = Scene().be(state="faulted", halt_reason=OVER, is_tissue_held=True).run(3.0)
    scene.event("refused", "tense", "halted (x); wait").run(1.0)
    assert set(scene.sounds()) == {Earcon.FAULT_HIGH}
    assert len(scene.board.standing) == 2


@pytest.mark.parametrize("before", [0.5, 3.0])  # [s] in the burst, and in the pause after it
def test_a_stop_is_heard_in_the_pauses_of_a_high_fault_and_cuts_none_of_its_bursts(before):
    scene = Scene().be(is_tissue_held=True)
    scene.health("voice_assist: voice", "recognition hangs").run(before)
    assert scene.sounds() == [Earcon.FAULT_HIGH]
    scene.be(state="halted", halt_reason=STOPPED).run(4.0)
    assert Earcon.STOP in scene.sounds()
    (first, _), (second, stop) = scene.heard[:2]
    assert stop is Earcon.STOP
    assert second - first >= PATTERNS[Earcon.FAULT_HIGH].duration + GAP - 0.051


def test_the_next_burst_of_a_high_fault_cuts_off_a_stop_that_sounds_in_its_pause():
    scene = Scene().be(is_tissue_held=True)
    for _ in range(6):  # [s] it speaks every second; 0.35 s before the next burst
        scene.health("voice_assist: voice", "recognition hangs").run(0.95)
    scene.be(state="halted", halt_reason=STOPPED).run(1.0)
    assert [earcon for _, earcon in scene.heard[1:]] == [Earcon.STOP, Earcon.FAULT_HIGH]
    _, stop, burst = (time for time, _ in scene.heard)
    assert burst - stop < PATTERNS[Earcon.STOP].duration


def test_notices_can_be_silenced_alone():
    scene = Scene(notices=False).event("accepted", "hey robot", "ready").run(1.0)
    assert scene.heard == []
    assert scene.be(state="halted", halt_reason=STOPPED).sounds() == [Earcon.STOP]


def test_a_failed_pull_is_over_with_the_next_command():
    words = "nothing grasped: no tissue between the closed jaws"
    scene = Scene().event("at_rest", "tense", words, "closed_on_nothing")
    assert scene.first.kind is Kind.FAULT
    assert scene.event("accepted", "tense", "goes").first.kind is Kind.NOTICE

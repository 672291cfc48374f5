# SPDX-License-Identifier: BSD-3-Clause
"""From what happens to what stands and sounds: priorities, acknowledgement, repetition."""

from dataclasses import replace
from itertools import pairwise

import pytest

from typed_config import load_file
from voice_assist.alarms.annunciator import GAP, Annunciator
from voice_assist.alarms.board import Board, wake_phrases
from voice_assist.alarms.earcons import PATTERNS
from voice_assist.alarms.presenter import event_alarm, latch_alarm, part_alarm, unheard_alarm
from voice_assist.alarms.types import (
    ControllerEvent,
    Earcon,
    Kind,
    PartHealth,
    Priority,
    RobotState,
    UtteranceReport,
)
from voice_assist.config import load_voice_config
from voice_assist.config.alarms import FILE, AlarmsConfig

CONFIG = load_file(AlarmsConfig, FILE)
STOPPED = "stopped by voice"
OVER = "tension 2.50 N, allowed 2.40 N"
LOST = "robot not connected"
OFF = "joint_4 0.060 rad off its set-point"
CODES = {STOPPED: "stop_topic", OVER: "over_tension", LOST: "not_connected", OFF: "off_setpoint"}


class Scene:
    """A controller and a voice node, told by hand; time goes on by `run`."""

    def __init__(self, **sound):
        self.board = Board(CONFIG.board)
        self.annunciator = Annunciator(replace(CONFIG.sound, **sound))
        self.now, self.robot = 0.0, RobotState(0.0, "active", is_active=True)
        self.heard = []  # of each sound the time, its name and whether it cut another off

    def be(self, **changes):
        if "halt_reason" in changes:
            changes["halt_reason_code"] = CODES.get(changes["halt_reason"], "")
        self.robot = replace(self.robot, **changes)
        return self.run(0.05)

    def event(self, kind, command="", message="", code=""):
        self.board.see_event(ControllerEvent(kind, command, message, code), self.now)
        return self.run(0.05)

    def health(self, name, message):
        self.board.see_health(PartHealth(name, bool(message), message), self.now)
        return self.run(0.05)

    def run(self, seconds, with_state=True):
        for _ in range(round(seconds / 0.05)):
            self.now += 0.05
            if with_state:
                self.board.see_state(replace(self.robot, stamp=self.now), self.now)
            self.board.tick(self.now)
            alarm = self.annunciator.next(self.board.standing, self.now)
            if alarm is not None:
                self.heard.append((round(self.now, 2), alarm.earcon))
        return self

    @property
    def first(self):
        return self.board.standing[0].alarm if self.board.standing else None

    def sounds(self):
        return [earcon for _, earcon in self.heard]


# What an alarm is: pure functions.


@pytest.mark.parametrize(
    ("reason", "is_loaded", "kind", "priority", "earcon"),
    [
        (STOPPED, True, Kind.STOP, Priority.MEDIUM, Earcon.STOP),
        (STOPPED, False, Kind.STOP, Priority.MEDIUM, Earcon.STOP),
        (OVER, True, Kind.FAULT, Priority.HIGH, Earcon.FAULT_HIGH),
        (LOST, False, Kind.FAULT, Priority.MEDIUM, Earcon.FAULT_MEDIUM),
        ("words of tomorrow", True, Kind.FAULT, Priority.HIGH, Earcon.FAULT_HIGH),
    ],
)
def test_a_latch_has_the_priority_of_its_cause_and_situation(
    reason, is_loaded, kind, priority, earcon
):
    alarm = latch_alarm(reason, CODES.get(reason, "code_of_tomorrow"), is_loaded)
    assert (alarm.kind, alarm.priority, alarm.earcon) == (kind, priority, earcon)
    assert alarm.cause == reason and "hey robot" in alarm.next_step


def test_a_refusal_is_low_and_keeps_the_controllers_words():
    words = 'in standby; say "hey robot" first'
    alarm = event_alarm(ControllerEvent("refused", "tense", words, "wrong_mode"), False)
    assert (alarm.kind, alarm.priority) == (Kind.REFUSAL, Priority.LOW)
    assert alarm.cause == f"tense: {words}" and alarm.next_step == 'Say "hey robot" first.'


@pytest.mark.parametrize(
    ("command", "earcon"),
    [
        ("hey robot", Earcon.ARMED),
        ("terminate", Earcon.STANDBY),
        ("pull more", Earcon.ACCEPTED),
    ],
)
def test_what_is_accepted_is_no_alarm(command, earcon):
    alarm = event_alarm(ControllerEvent("accepted", command, "does it"), True)
    assert (alarm.kind, alarm.priority, alarm.earcon) == (
        Kind.NOTICE,
        Priority.INFORMATION,
        earcon,
    )


@pytest.mark.parametrize(
    "event",
    [
        ControllerEvent("motion_started", "tense", "goes"),
        ControllerEvent("motion_finished", "tense", "tension 1.00 N"),
        ControllerEvent("at_rest", "tense", "terminated", "terminated"),
        ControllerEvent("at_rest", "tense", OVER, "over_tension"),  # its latch tells it
        ControllerEvent("halted", "tense", OVER, "over_tension"),
        ControllerEvent("stop_received", "stop", STOPPED, "stop_topic"),
        ControllerEvent("trocar_set", "set_trocar", "somewhere"),
    ],
)
def test_other_entries_of_the_diary_are_no_alarms_of_their_own(event):
    assert event_alarm(event, True) is None


def test_a_motion_that_is_given_up_with_tissue_held_is_of_medium_priority():
    words = "tension rose by 0.01 N over 2.0 mm of pull, at least"
    event = ControllerEvent("at_rest", "tense", words, "no_response_to_pull")
    assert event_alarm(event, True).priority is Priority.MEDIUM
    assert event_alarm(event, False).priority is Priority.LOW


@pytest.mark.parametrize(
    ("said", "is_told"),
    [
        (
            UtteranceReport("", "confidence 0.31", "unsure", "tense", 0.0),
            True,
        ),
        (
            UtteranceReport("", "it counts only in active mode", "wrong_mode", "tense", 0.0),
            True,
        ),
        (UtteranceReport("", "WER 0.67 to 'pull more'", "no_command", "pull more", 0.67), False),
        (UtteranceReport("", "it denies", "no_command", "pull more", 0.0), False),
        (UtteranceReport("", "nothing was said", "no_command", "", float("inf")), False),
        (UtteranceReport("tense", "", "", "tense", 0.0), False),
    ],
)
def test_only_the_words_of_a_command_that_was_not_taken_are_told(said, is_told):
    assert (unheard_alarm(said) is not None) == is_told


def test_a_deaf_microphone_is_worse_while_tissue_is_held():
    words = "default microphone: not found; microphones found: none"
    assert part_alarm("voice", words, "no_sound", is_loaded=False).priority is Priority.MEDIUM
    alarm = part_alarm("voice", words, "no_sound", is_loaded=True)
    assert alarm.priority is Priority.HIGH and "microphone" in alarm.next_step


# What stands, and for how long.


def test_nothing_happens_to_a_healthy_robot():
    scene = Scene().run(30.0)
    assert scene.board.standing == () and scene.heard == []


def test_a_stop_stands_until_the_latch_is_cleared():
    scene = Scene().be(state="moving").be(state="stopping", halt_reason=STOPPED)
    assert scene.first.kind is Kind.STOP
    scene.be(state="halted").run(60.0)
    assert scene.first.kind is Kind.STOP
    scene.event("accepted", "hey robot", "ready").be(state="active", halt_reason="")
    assert scene.first.earcon is Earcon.ARMED
    assert scene.run(10.0).board.standing == ()


def test_a_fault_in_motion_stays_of_high_priority_at_rest():
    scene = Scene().be(state="moving").be(state="stopping", halt_reason=OVER)
    assert scene.be(state="faulted").run(5.0).first.priority is Priority.HIGH


def test_a_fault_is_high_though_braking_was_too_short_to_be_seen():
    scene = Scene().be(state="moving").be(state="faulted", halt_reason=OVER)
    assert scene.first.priority is Priority.HIGH


def test_a_fault_at_rest_with_nothing_held_is_of_medium_priority():
    scene = Scene().be(state="faulted", halt_reason=OFF)
    assert scene.first.priority is Priority.MEDIUM


def test_a_fault_that_follows_a_stop_takes_its_place():
    scene = Scene().be(state="halted", halt_reason=STOPPED, is_tissue_held=True)
    scene.be(state="faulted", halt_reason=LOST)
    assert (scene.first.kind, scene.first.priority) == (Kind.FAULT, Priority.HIGH)


def test_a_refusal_is_shown_for_a_while_beside_what_stands():
    scene = Scene().be(state="halted", halt_reason=STOPPED)
    scene.event("refused", "tense", 'halted (stop); say "hey robot" to go on')
    assert [s.alarm.kind for s in scene.board.standing] == [Kind.STOP, Kind.REFUSAL]
    scene.run(CONFIG.board.shown_for)
    assert [s.alarm.kind for s in scene.board.standing] == [Kind.STOP]


def test_a_controller_that_falls_silent_is_noticed_by_its_stamps():
    scene = Scene().be(state="moving").run(2.0)
    scene.board.see_state(replace(scene.robot, stamp=scene.now), scene.now)  # the last, again
    scene.run(CONFIG.board.controller_silent_after + 0.2, with_state=False)
    assert scene.first.priority is Priority.HIGH and "controller" in scene.first.cause


def test_a_voice_node_that_falls_silent_is_noticed_once_it_was_heard():
    scene = Scene().run(20.0)
    assert scene.first is None
    scene.health("voice_assist: voice", "").run(CONFIG.board.voice_silent_after + 0.2)
    assert "no word" in scene.first.cause and scene.first.priority is Priority.MEDIUM


def test_parts_that_are_still_starting_are_no_alarm():
    scene = Scene()
    scene.robot = RobotState(0.0, "standby")
    scene.health("voice_assist: voice", "starting").run(2.0)
    assert scene.first is None
    scene.run(1.0).health("voice_assist: voice", "")
    assert scene.run(1.0).first is None


def test_a_lost_recording_is_low_and_goes_when_it_is_back():
    scene = Scene()
    scene.health("rst_control: recording", "not recorded: recorder silent for 1.2 s")
    assert scene.first.priority is Priority.LOW and "recorder" in scene.first.next_step
    assert scene.health("rst_control: recording", "").first is None


def test_a_lost_pedal_has_its_own_next_step():
    scene = Scene().health("pedal: pedal", "nobody publishes joy any more")
    assert scene.first.priority is Priority.LOW and "pedal" in scene.first.next_step
    assert scene.health("pedal: pedal", "").first is None


@pytest.mark.parametrize(
    ("name", "first", "second"),
    [
        ("alarms: strangers", "not believed: /a from /x", "not believed: /a from /x, /a from /y"),
        ("rst_control: settings", "not those of the launch: a is 1", "not those of the launch: b"),
    ],
)
def test_a_new_stranger_or_setting_is_named_and_told_though_one_was_seen_to(name, first, second):
    scene = Scene().health(name, first).event("refused", "hey robot", "x").run(3.0)
    before = scene.sounds().count(Earcon.FAULT_MEDIUM) + scene.sounds().count(Earcon.FAULT_LOW)
    scene.health(name, first).run(3.0)
    faults = [s for s in scene.board.standing if s.alarm.kind is Kind.FAULT]
    assert first in faults[0].alarm.cause and faults[0].is_acknowledged
    scene.health(name, second).run(3.0)
    faults = [s for s in scene.board.standing if s.alarm.kind is Kind.FAULT]
    assert second in faults[0].alarm.cause and not faults[0].is_acknowledged
    after = scene.sounds().count(Earcon.FAULT_MEDIUM) + scene.sounds().count(Earcon.FAULT_LOW)
    assert after == before + 1


def test_other_numbers_in_a_parts_message_are_no_news():
    scene = Scene().health("rst_control: recording", "recorder silent for 1.2 s").run(1.0)
    scene.health("rst_control: recording", "recorder silent for 2.2 s").run(1.0)
    assert "1.2 s" in scene.first.cause and scene.sounds() == [Earcon.FAULT_LOW]


def test_another_trouble_of_the_same_part_is_told_once():
    scene = Scene().health("pedal: pedal", "not found yet").run(3.0)
    sounds = scene.sounds()
    scene.health("pedal: pedal", "'/dev/input/event5' is not readable").run(3.0)
    assert "is not readable" in scene.first.cause and len(scene.sounds()) == len(sounds) + 1


def test_the_alarm_of_a_part_whose_node_has_ended_goes_and_that_of_one_that_speaks_stays():
    scene = Scene().health("pedal: pedal", "the device is gone").run(1.0)
    for _ in range(20):
        scene.health("rst_control: recording", "nobody records").run(1.0)
    assert [s.key for s in scene.board.standing] == ["part recording"]


@pytest.mark.parametrize(
    ("language", "said", "is_seen_to"),
    [
        ("en", "hey robot", True),
        ("de", "hallo roboter", True),
        ("de", "hey robot", False),
        ("de", "stop", False),
    ],
)
def test_the_wake_phrase_of_the_language_acknowledges_by_itself(language, said, is_seen_to):
    scene = Scene()
    scene.board = Board(CONFIG.board, wake_phrases(load_voice_config(language=language).commands))
    scene.be(state="halted", halt_reason=STOPPED)
    scene.board.see_utterance(UtteranceReport(said, "", "", said, 0.0), scene.now)
    assert scene.board.standing[0].is_acknowledged is is_seen_to


def test_without_known_commands_hey_robot_acknowledges():
    scene = Scene().be(state="halted", halt_reason=STOPPED)
    scene.board.see_utterance(UtteranceReport("hey robot", "", "", "hey robot", 0.0), scene.now)
    assert scene.board.standing[0].is_acknowledged


def test_a_fault_that_gets_worse_is_told_again():
    scene = Scene().health("rst_control: recording", "not recorded: x")
    scene.be(is_tissue_held=True)
    assert scene.first.priority is Priority.MEDIUM
    assert scene.sounds() == [Earcon.FAULT_LOW, Earcon.FAULT_MEDIUM]


# What sounds, and when.


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


def test_stop_said_again_is_heard_again():
    scene = Scene().be(state="halted", halt_reason=STOPPED).run(3.0)
    scene.event("stop_received", "stop", STOPPED, "stop_topic").run(1.0)
    assert scene.sounds() == [Earcon.STOP] * 2


def test_the_entry_of_the_same_stop_is_not_heard_twice_at_once():
    scene = Scene().be(state="stopping", halt_reason=STOPPED)
    scene.event("stop_received", "stop", STOPPED, "stop_topic").run(0.5)
    assert scene.sounds() == [Earcon.STOP]


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


def test_notices_can_be_silenced_alone():
    scene = Scene(notices=False).event("accepted", "hey robot", "ready").run(1.0)
    assert scene.heard == []
    assert scene.be(state="halted", halt_reason=STOPPED).sounds() == [Earcon.STOP]


def test_a_failed_pull_is_over_with_the_next_command():
    words = "nothing grasped: no tissue between the closed jaws"
    scene = Scene().event("at_rest", "tense", words, "closed_on_nothing")
    assert scene.first.kind is Kind.FAULT
    assert scene.event("accepted", "tense", "goes").first.kind is Kind.NOTICE

# SPDX-License-Identifier: BSD-3-Clause
"""From what happens to the alarms that stand: their priority, acknowledgement and end."""

from dataclasses import replace

import pytest

from tests.unit.voice_assist.support.alarm_scene import (
    CODES,
    CONFIG,
    LOST,
    OFF,
    OVER,
    STOPPED,
    Scene,
)
from voice_assist.alarms.board import FORGOTTEN_AFTER, Board, wake_phrases
from voice_assist.alarms.presenter import event_alarm, latch_alarm, part_alarm, unheard_alarm
from voice_assist.alarms.types import (
    ControllerEvent,
    Earcon,
    Kind,
    Priority,
    RobotState,
    UtteranceReport,
)
from voice_assist.config import load_voice_config

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
    [("hey robot", Earcon.ARMED), ("terminate", Earcon.STANDBY), ("pull more", Earcon.ACCEPTED)],
)
def test_what_is_accepted_is_no_alarm(command, earcon):
    alarm = event_alarm(ControllerEvent("accepted", command, "does it"), True)
    assert (alarm.kind, alarm.priority, alarm.earcon) == (Kind.NOTICE, Priority.INFORMATION, earcon)


@pytest.mark.parametrize(
    "event",
    [
        ControllerEvent("motion_started", "tense", "goes"),
        ControllerEvent("motion_finished", "tense", "tension 1.00 N"),
        ControllerEvent("at_rest", "tense", "terminated", "terminated"),
        ControllerEvent("at_rest", "tense", OVER, "over_tension"),  # its latch reports it
        ControllerEvent("halted", "tense", OVER, "over_tension"),
        ControllerEvent("stop_received", "stop", STOPPED, "stop_topic"),
        ControllerEvent("trocar_set", "set_trocar", "somewhere"),
    ],
)
def test_other_events_are_no_alarms_of_their_own(event):
    assert event_alarm(event, True) is None


def test_a_motion_that_is_given_up_with_tissue_held_is_of_medium_priority():
    words = "tension rose by 0.01 N over 2.0 mm of pull, at least"
    event = ControllerEvent("at_rest", "tense", words, "no_response_to_pull")
    assert event_alarm(event, True).priority is Priority.MEDIUM
    assert event_alarm(event, False).priority is Priority.LOW


@pytest.mark.parametrize(
    ("said", "is_alarm"),
    [
        (UtteranceReport("", "confidence 0.31", "unsure", "tense", 0.0), True),
        (UtteranceReport("", "it counts only in active mode", "wrong_mode", "tense", 0.0), True),
        (UtteranceReport("", "nearly sure", "nearly_sure", "tense", 0.0), True),
        (UtteranceReport("", "nearly sure", "nearly_sure", "tense", 1.0), True),
        (UtteranceReport("", "WER 0.67 to 'pull more'", "no_command", "pull more", 0.67), False),
        (UtteranceReport("", "it denies", "no_command", "pull more", 0.0), False),
        (UtteranceReport("", "nothing was said", "no_command", "", float("inf")), False),
        (UtteranceReport("tense", "", "", "tense", 0.0), False),
    ],
)
def test_only_a_question_and_the_words_of_a_command_that_was_not_taken_are_an_alarm(said, is_alarm):
    assert (unheard_alarm(said) is not None) == is_alarm


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


@pytest.mark.parametrize(
    ("states", "reason", "priority"),
    [
        (("moving", "stopping", "faulted"), OVER, Priority.HIGH),
        (("moving", "faulted"), OVER, Priority.HIGH),  # braking was too short to be seen
        (("faulted",), OFF, Priority.MEDIUM),  # at rest, with nothing held
    ],
)
def test_a_fault_in_motion_stays_of_high_priority_at_rest(states, reason, priority):
    scene = Scene()
    for state in states:
        scene.be(state=state, halt_reason="" if state == "moving" else reason)
    assert scene.run(5.0).first.priority is priority


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


@pytest.mark.parametrize("said", ["", "the device is gone"])
@pytest.mark.parametrize(
    ("state", "priority"), [("active", Priority.MEDIUM), ("moving", Priority.HIGH)]
)
def test_a_pedal_node_that_hangs_is_an_alarm_also_after_one_of_its_device(said, state, priority):
    scene = Scene().be(state=state).health("pedal: pedal", said)
    for _ in range(30):  # [s] it speaks every second
        scene.health("pedal: pedal", said).run(0.95)
    assert (scene.first is None) is (not said)
    scene.run(CONFIG.board.pedal_silent_after + 0.2)
    for _ in range(2):
        assert scene.first.cause.startswith("pedal: no word") and scene.first.priority is priority
        assert "start the pedal node again" in scene.first.next_step
        scene.run(FORGOTTEN_AFTER)
    assert scene.health("pedal: pedal", "").first is None


def test_a_pedal_that_was_never_there_is_no_alarm():
    scene = Scene().health("pedal: strangers", "").run(2.0 * CONFIG.board.starting_for)
    assert scene.first is None


@pytest.mark.parametrize(
    ("state", "priority"), [("active", Priority.LOW), ("moving", Priority.MEDIUM)]
)
def test_a_devices_node_that_falls_silent_is_a_mild_fault_once_it_was_heard(state, priority):
    scene = Scene().be(state=state).run(2.0 * CONFIG.board.starting_for)
    assert scene.first is None  # most systems have none
    for _ in range(30):  # [s] it speaks every second
        assert scene.health("devices: strangers", "").run(0.95).first is None
    scene.run(CONFIG.board.devices_silent_after + 0.2)
    for _ in range(2):
        assert scene.first.cause.startswith("devices: no word") and scene.first.priority is priority
        assert "Start the devices node again" in scene.first.next_step
        scene.run(FORGOTTEN_AFTER)
    assert scene.health("devices: strangers", "").first is None


def test_a_stranger_on_the_topics_of_the_devices_node_is_named_and_no_silence():
    words = "not believed: /voice_assist/utterance from /x"
    scene = Scene().health("devices: strangers", words).run(1.0)
    assert scene.first.cause == f"strangers of the devices: {words}"
    assert [standing.key for standing in scene.board.standing] == ["part strangers of the devices"]


@pytest.mark.parametrize(
    ("name", "limit"),
    [
        ("voice_assist: voice", CONFIG.board.voice_silent_after),
        ("pedal: pedal", CONFIG.board.pedal_silent_after),
    ],
)
def test_a_node_that_was_ended_on_purpose_sounds_no_more_once_it_is_acknowledged(name, limit):
    scene = Scene().health(name, "").run(limit + 0.2)
    assert scene.sounds() == [Earcon.FAULT_MEDIUM]
    scene.event("refused", "hey robot", "x").run(10.0 * CONFIG.sound.repeat_medium)
    assert scene.sounds().count(Earcon.FAULT_MEDIUM) == 1
    assert "no word" in scene.first.cause and scene.board.standing[0].is_acknowledged


def test_parts_that_are_still_starting_are_no_alarm():
    scene = Scene()
    scene.robot = RobotState(0.0, "standby")
    scene.health("voice_assist: voice", "starting").run(2.0)
    assert scene.first is None
    scene.run(1.0).health("voice_assist: voice", "")
    assert scene.run(1.0).first is None


def test_a_dead_part_is_an_alarm_at_once_in_standby_with_tissue_held():
    scene = Scene()
    scene.robot = RobotState(0.0, "standby", is_tissue_held=True)
    scene.health("voice_assist: voice", "no sound")
    assert scene.first.priority is Priority.HIGH


@pytest.mark.parametrize(
    ("name", "words", "step"),
    [
        ("rst_control: recording", "not recorded: recorder silent for 1.2 s", "recorder"),
        ("pedal: pedal", "nobody publishes joy any more", "pedal"),
    ],
)
def test_a_lost_recording_or_pedal_is_low_with_its_own_next_step_and_goes_when_it_is_back(
    name, words, step
):
    scene = Scene().health(name, words)
    assert scene.first.priority is Priority.LOW and step in scene.first.next_step
    assert scene.health(name, "").first is None


@pytest.mark.parametrize(
    ("name", "first", "second"),
    [
        ("alarms: strangers", "not believed: /a from /x", "not believed: /a from /x, /a from /y"),
        ("rst_control: settings", "not those of the launch: a is 1", "not those of the launch: b"),
    ],
)
def test_a_new_stranger_or_setting_is_named_and_sounds_though_one_was_seen_to(name, first, second):
    scene = Scene().health(name, first).event("refused", "hey robot", "x").run(3.0)

    def sounded():
        return sum(one in (Earcon.FAULT_MEDIUM, Earcon.FAULT_LOW) for one in scene.sounds())

    before = sounded()
    for words, is_seen_to in ((first, True), (second, False)):
        scene.health(name, words).run(3.0)
        fault = next(s for s in scene.board.standing if s.alarm.kind is Kind.FAULT)
        assert words in fault.alarm.cause and fault.is_acknowledged is is_seen_to
    assert sounded() == before + 1


def test_other_numbers_in_a_parts_message_are_no_news():
    scene = Scene().health("rst_control: recording", "recorder silent for 1.2 s").run(1.0)
    scene.health("rst_control: recording", "recorder silent for 2.2 s").run(1.0)
    assert "1.2 s" in scene.first.cause and scene.sounds() == [Earcon.FAULT_LOW]


@pytest.mark.parametrize(("first", "second"), [("joint_2", "joint_5"), ("arm-1", "arm-2")])
def test_another_number_in_a_name_is_news_though_the_first_was_seen_to(first, second):
    scene = Scene().health("rst_control: motion", f"robot fault: {first}: x")
    scene.event("refused", "hey robot", "x").run(3.0)
    scene.health("rst_control: motion", f"robot fault: {second}: x").run(3.0)
    fault = next(s for s in scene.board.standing if s.alarm.kind is Kind.FAULT)
    assert second in fault.alarm.cause and not fault.is_acknowledged
    assert scene.sounds().count(Earcon.FAULT_LOW) == 2


def test_another_trouble_of_the_same_part_sounds_once():
    scene = Scene().health("pedal: pedal", "not found yet").run(3.0)
    sounds = scene.sounds()
    scene.health("pedal: pedal", "'/dev/input/event5' is not readable").run(3.0)
    assert "is not readable" in scene.first.cause and len(scene.sounds()) == len(sounds) + 1


def test_the_alarm_of_a_part_whose_node_has_ended_goes_and_that_of_one_that_speaks_stays():
    scene = Scene().health("rst_control: control loop", "late").run(1.0)
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
        ("", "hey robot", True),  # no commands are known
    ],
)
def test_the_wake_phrase_of_the_language_acknowledges_by_itself(language, said, is_seen_to):
    scene = Scene()
    if language:
        wakes = wake_phrases(load_voice_config(language=language).commands)
        scene.board = Board(CONFIG.board, wakes)
    scene.be(state="halted", halt_reason=STOPPED)
    scene.board.see_utterance(UtteranceReport(said, "", "", said, 0.0), scene.now)
    assert scene.board.standing[0].is_acknowledged is is_seen_to


def test_a_fault_that_gets_worse_sounds_again():
    scene = Scene().health("rst_control: recording", "not recorded: x")
    scene.be(is_tissue_held=True)
    assert scene.first.priority is Priority.MEDIUM
    assert scene.sounds() == [Earcon.FAULT_LOW, Earcon.FAULT_MEDIUM]

# SPDX-License-Identifier: BSD-3-Clause
"""Every reason code that the controller, the recogniser or a status gives has its next step."""

import re
from pathlib import Path

import numpy as np
import pytest

import rst_control.types
from rst_control.execution.orders import Outcome, Reply
from rst_control.types import ROBOT_FAULTS, Cause, Reason, robot_fault
from tests.unit.voice_assist.audio.test_input_check import DEAFENING, LONG, watched
from voice_assist.alarms.causes import (
    GIVE_UPS,
    LATCHES,
    NO_REASON,
    PARTS,
    REFUSALS,
    SILENT,
    UNHEARD,
    UNKNOWN,
    part_advice,
)
from voice_assist.alarms.presenter import event_alarm, latch_alarm
from voice_assist.alarms.types import ControllerEvent, Kind
from voice_assist.types import HearingFault, RejectionReason

ENDED_AS_ASKED = ("terminated", "replaced")  # motions that end without an alarm
PACKAGE = Path(rst_control.types.__file__).parent
MESSAGES = PACKAGE.parents[1] / "msg"
SOURCES = {path: path.read_text(encoding="utf-8") for path in PACKAGE.rglob("*.py")}
TABLES = (LATCHES, GIVE_UPS, REFUSALS, UNHEARD, PARTS)
CODES = {reason.value for reason in Reason}


def named(constructor):
    """The reasons that the code gives to a `constructor(Reason.X, ...)`."""
    pattern = re.compile(rf"\b{constructor}\(\s*Reason\.(\w+)")
    return {Reason[name] for text in SOURCES.values() for name in pattern.findall(text)}


def test_the_message_lists_the_codes_of_the_enumeration():
    text = (MESSAGES / "ReasonCode.msg").read_text(encoding="utf-8")
    assert dict(re.findall(r"^string (\w+)=(\w+)$", text, re.MULTILINE)) == {
        reason.name: reason.value for reason in Reason
    }


@pytest.mark.parametrize("reason", Reason)
def test_every_reason_has_a_next_step_or_ends_a_motion_as_asked(reason):
    assert reason.value in {*LATCHES, *GIVE_UPS, *REFUSALS, *ENDED_AS_ASKED}


def test_no_table_has_a_code_that_controller_recogniser_or_status_does_not_give():
    assert {*LATCHES, *GIVE_UPS, *REFUSALS, *ENDED_AS_ASKED} <= CODES
    assert set(UNHEARD) <= {reason.value for reason in RejectionReason}
    given = {fault.value for fault in HearingFault} | CODES | {SILENT}
    assert {key.partition(": ")[2] for key in PARTS} - {""} <= given


def test_every_reason_of_a_refusal_has_a_next_step_after_a_refusal():
    refusals = named("Rejected")
    assert {Reason.BUSY, Reason.HALTED, Reason.TENSION_LIMIT, Reason.NOT_INSERTED} <= refusals
    assert {reason.value for reason in refusals} <= set(REFUSALS)


def test_every_fault_of_the_robot_has_a_next_step_as_a_latch_and_as_a_refusal():
    assert {reason.value for reason in ROBOT_FAULTS} <= set(LATCHES) & set(REFUSALS)


def test_every_reason_that_the_code_names_leads_somewhere():
    given = named("Cause") | named("Rejected")
    assert {Reason.STOP_TOPIC, Reason.LOOP_ERROR, Reason.CLOSED_ON_NOTHING} <= given
    unused = set(Reason) - {r for r in Reason if f"Reason.{r.name}" in "".join(SOURCES.values())}
    assert unused == set()


@pytest.mark.parametrize("reason", [None, Reason.BUSY])
def test_a_reason_is_given_to_what_does_not_succeed_and_to_nothing_else(reason):
    made = (lambda: Reply(reason is not None, "x", reason), lambda: Outcome("failed", "x", None))
    for make in made[: 2 if reason is None else 1]:
        with pytest.raises(ValueError, match="reason"):
            make()


@pytest.mark.parametrize("reason", ROBOT_FAULTS)
def test_the_code_of_a_fault_comes_through_a_topic_of_strings(reason):
    cause = Cause(reason, "joint_4: it is blocked")
    assert robot_fault(cause.coded) == cause


@pytest.mark.parametrize("text", ["brakes on", "busy: homing", "stop_topic: x", ""])
def test_words_without_a_code_of_a_robot_fault_are_a_robot_fault(text):
    assert robot_fault(text) == Cause(Reason.FAULTED, text)


@pytest.mark.parametrize("reason", RejectionReason)
def test_every_reason_of_the_recogniser_has_a_next_step_or_is_other_talk(reason):
    assert (reason.value in UNHEARD) is (reason is not RejectionReason.NO_COMMAND)


@pytest.mark.parametrize("fault", HearingFault)
def test_every_fault_of_hearing_has_a_next_step(fault):
    assert part_advice("voice", fault.value) is not UNKNOWN


@pytest.mark.parametrize("part", ["voice", "recording", "control loop", "motion"])
def test_a_part_with_an_unknown_code_has_the_next_step_of_the_part(part):
    assert part_advice(part, "code_of_tomorrow") is PARTS[part]


def test_every_next_step_is_a_short_sentence_that_asks_for_something():
    for advice in (*(a for table in TABLES for a in table.values()), UNKNOWN, NO_REASON):
        step_words = advice.next_step
        assert 10 <= len(step_words) <= 80 and step_words[0].isupper(), step_words
        assert step_words.endswith("."), step_words


def test_a_lost_recording_that_stops_is_a_fault_and_no_persons_stop():
    advice = LATCHES[Reason.NOT_RECORDED.value]
    assert advice.kind is Kind.FAULT and "recorder" in advice.next_step


@pytest.mark.parametrize("code", ["", "code_of_tomorrow"])
def test_a_code_that_nobody_foresaw_gets_the_general_next_step(code):
    assert latch_alarm("the moon fell down", code, True).next_step == UNKNOWN.next_step
    event = ControllerEvent("refused", "tense", "because it is Tuesday", code)
    assert event_alarm(event, False).next_step == NO_REASON.next_step


def test_a_microphone_that_gives_nothing_of_use_says_which_kind_it_is():
    assert watched(np.zeros(LONG)).fault is HearingFault.MUTED
    assert watched(DEAFENING).fault is HearingFault.OVERLOADED
